// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <httplib.h>

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <list>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

namespace slipstack::workbench {

/// What the connections of one server may take. The defaults are chosen: a page opens six connections, one of
/// them for its events.
struct ConnectionLimits {
  /// A client is left that takes so long for the head of a request, or makes the server wait so long after
  /// it.
  std::chrono::milliseconds stalled{10000};
  /// ... and so much longer for each megabyte of a body or of an answer: slower is nobody on this machine.
  std::chrono::milliseconds for_each_megabyte{1000};
  /// Between two requests.
  std::chrono::milliseconds idle{60000};
  std::size_t waiting =
      512;  ///< connections without a whole request: descriptors, of which a process has 1024
  std::size_t threads = 256;  ///< requests at a time, those that stay open among them
  std::size_t large = 2;      ///< large ones at a time; the others wait and hold no thread
  std::size_t small_bytes = std::size_t{4} << 20;  ///< body of any but a large request
  std::size_t large_bytes = std::size_t{1} << 30;  ///< 3e7 samples of text
  std::size_t head_bytes = std::size_t{32} << 10;
};

/// The HTTP library's server, but with connections that hold a thread only from the moment when the head of a
/// request is there until its answer is taken: the library gives each connection a thread for as long as it
/// is open, so that two dozen clients that send nothing, or a byte now and then, would keep out everybody
/// else. Memory is bounded by the limits, whatever the clients do.
class PageServer : public httplib::Server {
 public:
  /// Whether a request is a large one, by its path: an upload, a download.
  using IsLarge = bool (*)(std::string_view path);

  PageServer(const ConnectionLimits& limits, IsLarge is_large);
  ~PageServer() override;
  /// To be called once the port is bound. The library lets five connections wait to be accepted, and a page
  /// opens six at once: the sixth would be tried again after a second (tcp_syn_retries).
  void widen_backlog() const;
  PageServer(const PageServer&) = delete;
  PageServer& operator=(const PageServer&) = delete;

 private:
  using Clock = std::chrono::steady_clock;
  struct Connection;
  class Stream;
  class Queue;
  using Connections = std::list<std::unique_ptr<Connection>>;

  bool process_and_close_socket(socket_t socket) override;
  void wait_for_requests();
  void receive(Connections& waiting, Connections::iterator place);
  /// Moves a connection whose next request has arrived to those that are served.
  void offer(std::unique_ptr<Connection> connection);
  void serve_requests();
  void serve(std::unique_ptr<Connection> connection);
  void keep(std::unique_ptr<Connection> connection);
  void wake() const;
  void finish();

  ConnectionLimits limits_;
  IsLarge is_large_;
  int wake_ = -1;  ///< an eventfd: there is something to wait for
  std::mutex lock_;
  std::condition_variable offered_;
  Connections arrived_;  ///< for wait_for_requests()
  Connections ready_;    ///< their request waits for a thread
  std::size_t idle_threads_ = 0;
  std::size_t large_ = 0;  ///< large requests that are served
  bool ending_ = false;
  std::atomic<bool> ended_{false};  ///< the same, for whoever waits for a client
  std::thread waiting_;
  std::vector<std::thread> threads_;
};

}  // namespace slipstack::workbench
