// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "firmware/canopen/application.h"
#include "firmware/canopen/connection_supervision/heartbeat.h"
#include "firmware/canopen/model/parameter_set.h"
#include "firmware/canopen/network/counter.h"
#include "firmware/canopen/network/emergency.h"
#include "firmware/canopen/network/lss.h"
#include "firmware/canopen/network/outbox.h"
#include "firmware/canopen/network/periodic_timer.h"
#include "firmware/canopen/network/sync_producer.h"
#include "firmware/canopen/objects/dictionary.h"
#include "firmware/canopen/pdo/pdo.h"
#include "firmware/canopen/sdo/access_lock.h"
#include "firmware/canopen/sdo/sdo_server.h"
#include "hal/include/can_port.h"

namespace slipstack::canopen {

/// The services of a node and the state that they share: the node drives them by frames and time, the objects
/// of communication show and set them.
struct NodeParts {
  NodeParts(CanPort& can, RecordSlots& storage, Application& served, ObjectAccess& objects)
      : port(can),
        application(served),
        set(storage),
        dictionary(objects),
        sdo(dictionary),
        pdos(dictionary),
        heartbeats(dictionary) {}

  bool may_write() const { return lock.allows_writing(); }

  CanPort& port;
  Application& application;
  ParameterSet set;
  Dictionary dictionary;
  SdoServer sdo;
  Pdos pdos;
  HeartbeatConsumer heartbeats;
  Emergency emergency;
  Lss lss;
  AccessLock lock;
  Outbox outbox;
  std::uint8_t node = Lss::kUnconfigured;
  std::uint32_t now_us = 0;
  PeriodicTimer heartbeat_timer;
  SyncProducer sync_producer;
  std::uint32_t received = 0;
  std::uint32_t malformed = 0;
  std::uint32_t bus_offs = 0;
};

}  // namespace slipstack::canopen
