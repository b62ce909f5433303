// SPDX-License-Identifier: Apache-2.0
#include "hal/stm32g474/can.h"

#include <gtest/gtest.h>

#include <deque>
#include <memory>
#include <random>
#include <vector>

#include "tests/unit/stm32g474/simulated_word.h"

namespace slipstack::stm32g474 {
namespace {
using test::SimWord;

constexpr CanBitTiming kTiming = plan_can_timing(24'000'000, 1'000'000);

CanFrame frame_of(std::uint32_t id, std::vector<std::uint8_t> data) {
  CanFrame frame;
  frame.id = id;
  frame.length = static_cast<std::uint8_t>(data.size());
  std::copy(data.begin(), data.end(), frame.data.begin());
  return frame;
}

// The FDCAN as the manual describes it: configuration behind INIT and CCE, acceptance filters, three-frame
// FIFOs in the message RAM. Written from the manual's side: whole words, bits by number.
struct SimCan {
  Fdcan<SimWord> registers;
  CanMessageRam<SimWord> ram;
  std::unique_ptr<Can<Fdcan<SimWord>, CanMessageRam<SimWord>>> can =
      std::make_unique<Can<Fdcan<SimWord>, CanMessageRam<SimWord>>>(registers, ram);
  bool answers = true;
  bool bus_off = false;
  bool interrupts_by_hand = false;
  std::deque<std::uint32_t> transmit_queue;  // slots
  std::uint32_t put = 0;
  std::uint32_t cancelled = 0;
  struct Fifo {
    std::uint32_t get = 0;
    std::uint32_t level = 0;
    std::uint32_t taken = 0;
  } fifo[2];

  SimCan() {
    registers.cccr.value = 1;  // INIT after reset
    registers.rxgfc.value = 0;
    registers.cccr.on_write = [this](SimWord& self, std::uint32_t written) {
      if (!answers) return;
      const bool leaves = (self.value & 1U) != 0 && (written & 1U) == 0;
      self.value = (written & 1U) != 0 ? written : written & ~2U;
      if (leaves) bus_off = false;  // after 129 x 11 recessive bits, here at once
    };
    for (SimWord* protected_word : {&registers.nbtp, &registers.rxgfc, &registers.txbc}) {
      protected_word->on_write = [this](SimWord& self, std::uint32_t written) {
        if ((registers.cccr.value & 3U) == 3U) self.value = written;
      };
    }
    test::clear_by_one(registers.ir);
    registers.psr.on_read = [this](std::uint32_t value) { return bus_off ? value | 1U << 7U : value; };
    registers.txfqs.on_read = [this](std::uint32_t) {
      const auto waiting = static_cast<std::uint32_t>(transmit_queue.size());
      return (3 - waiting) | put << 16U | (waiting == 3 ? 1U << 21U : 0U);
    };
    registers.txbar.on_write = [this](SimWord&, std::uint32_t written) {
      ASSERT_EQ(written, 1U << put) << "a FIFO takes its slots in turn";
      ASSERT_LT(transmit_queue.size(), 3U);
      transmit_queue.push_back(put);
      put = (put + 1) % 3;
    };
    registers.txbcr.on_write = [this](SimWord&, std::uint32_t written) {
      cancelled |= written;
      transmit_queue.clear();
    };
    attach_fifo(0, registers.rxf0s, registers.rxf0a);
    attach_fifo(1, registers.rxf1s, registers.rxf1a);
  }

  void attach_fifo(std::size_t number, SimWord& status, SimWord& acknowledge) {
    status.on_read = [this, number](std::uint32_t) {
      return fifo[number].level | fifo[number].get << 8U | (fifo[number].level == 3 ? 1U << 24U : 0U);
    };
    acknowledge.on_write = [this, number](SimWord&, std::uint32_t written) {
      ASSERT_EQ(written, fifo[number].get);
      ASSERT_GT(fifo[number].level, 0U);
      fifo[number].get = (fifo[number].get + 1) % 3;
      --fifo[number].level;
      ++fifo[number].taken;
    };
  }

  CanFault start(const std::vector<CanFilter>& filters = {}) { return can->start(kTiming, filters); }

  // Which FIFO takes the frame; -1: none.
  int accepting(const CanFrame& frame) const {
    const std::uint32_t global = registers.rxgfc.value;
    if (frame.remote && (global & (frame.extended ? 1U : 2U)) != 0) return -1;
    if (!frame.extended) {
      for (std::uint32_t i = 0; i < ((global >> 16U) & 0x1FU); ++i) {
        const std::uint32_t element = ram.standard_filters[i].value;
        const std::uint32_t id = (element >> 16U) & 0x7FFU;
        const std::uint32_t mask = element & 0x7FFU;
        if (element >> 30U != 2U || (frame.id & mask) != (id & mask)) continue;
        return static_cast<int>((element >> 27U) & 7U) - 1;
      }
    }
    const std::uint32_t others = (global >> (frame.extended ? 2U : 4U)) & 3U;
    return others < 2 ? static_cast<int>(others) : -1;
  }

  // A frame arrives from the bus.
  void arrive(const CanFrame& frame) {
    if ((registers.cccr.value & 1U) != 0) return;
    const int to = accepting(frame);
    if (to < 0) return;
    const auto number = static_cast<std::uint32_t>(to);
    Fifo& into = fifo[number];
    if (into.level == 3) {
      registers.ir.value |= 1U << (2 + 3 * number);
    } else {
      auto& element = ram.rx_fifo[number][(into.get + into.level) % 3];
      element.header[0].value = (frame.extended ? frame.id | 1U << 30U : frame.id << 18U) |
                                (frame.remote ? 1U << 29U : 0U) | 1U << 31U;
      element.header[1].value =
          std::uint32_t{frame.length} << 16U | 0x0012'3456U % 0x10000U;  // a time stamp below
      for (std::size_t i = 0; i < 2; ++i) {
        element.data[i].value = frame.data[4 * i] | std::uint32_t{frame.data[4 * i + 1]} << 8U |
                                std::uint32_t{frame.data[4 * i + 2]} << 16U |
                                std::uint32_t{frame.data[4 * i + 3]} << 24U;
      }
      ++into.level;
      registers.ir.value |= 1U << (3 * number);
    }
    if (!interrupts_by_hand && (registers.ir.value & registers.ie.value) != 0) can->on_interrupt();
  }

  // The bus takes the oldest frame that waits.
  CanFrame transmitted() {
    EXPECT_FALSE(transmit_queue.empty());
    const auto& element = ram.tx_buffers[transmit_queue.front()];
    transmit_queue.pop_front();
    CanFrame frame;
    const std::uint32_t header = element.header[0].value;
    frame.extended = (header >> 30U & 1U) != 0;
    frame.remote = (header >> 29U & 1U) != 0;
    frame.id = frame.extended ? header & 0x1FFFFFFFU : header >> 18U & 0x7FFU;
    const std::uint32_t control = element.header[1].value;
    EXPECT_EQ(control & 0x00300000U, 0U) << "classic frames only";
    frame.length = static_cast<std::uint8_t>(control >> 16U & 0xFU);
    for (std::size_t i = 0; i < 8; ++i) {
      frame.data[i] = static_cast<std::uint8_t>(element.data[i / 4].value >> (8 * (i % 4)));
    }
    return frame;
  }
};

TEST(Can, StartsAsClassicCanWithTheBitTimingLessOne) {
  SimCan sim;
  sim.ram.standard_filters[27].value = 0xFFFFFFFF;  // RAM is not cleared by a reset
  ASSERT_EQ(sim.start(), CanFault::kNone);
  EXPECT_EQ(sim.registers.nbtp.value, 2U << 25U | 0U << 16U | 19U << 8U | 2U);
  EXPECT_EQ(sim.registers.cccr.value, 0U) << "on the bus; no FD, no test, retransmission on";
  EXPECT_EQ(sim.registers.txbc.value, 0U);
  EXPECT_EQ(sim.registers.ie.value, 1U | 1U << 2U | 1U << 3U | 1U << 5U | 1U << 19U);
  EXPECT_EQ(sim.registers.ile.value, 1U);
  EXPECT_EQ(sim.ram.standard_filters[27].value, 0U);
}

TEST(Can, RefusesASetUpThatCannotWork) {
  SimCan sim;
  EXPECT_EQ(sim.can->start(CanBitTiming{}, {}), CanFault::kBadTiming);
  EXPECT_EQ(sim.start(std::vector<CanFilter>(29)), CanFault::kTooManyFilters);
  EXPECT_EQ(sim.start({{.id = 0x800, .mask = 0x7FF, .fifo = 0}}), CanFault::kBadFilter);
  EXPECT_EQ(sim.start({{.id = 0, .mask = 0x800, .fifo = 0}}), CanFault::kBadFilter);
  EXPECT_EQ(sim.start({{.id = 0, .mask = 0, .fifo = 2}}), CanFault::kBadFilter);
  EXPECT_EQ(sim.registers.cccr.value, 1U) << "refused: untouched";
  sim.answers = false;
  sim.registers.cccr.value = 0;
  EXPECT_EQ(sim.start(), CanFault::kNoAnswer);
}

// At a wrong rate a node destroys the frames of all others: it joins when the stored rate is known.
TEST(Can, JoinsTheBusOnlyAtTheRateThatItIsGiven) {
  SimCan sim;
  ASSERT_EQ(sim.can->start(plan_can_timing(24'000'000, 1'000'000), {}, 24'000'000, false), CanFault::kNone);
  EXPECT_EQ(sim.registers.cccr.value & 1U, 1U) << "INIT: off the bus";
  ASSERT_TRUE(sim.can->set_bit_rate(250'000));
  EXPECT_EQ(sim.registers.cccr.value & 1U, 0U);
  const std::uint32_t nbtp = sim.registers.nbtp.value;
  const std::uint32_t quanta = 1 + (nbtp >> 8U & 0xFFU) + 1 + (nbtp & 0x7FU) + 1;
  EXPECT_EQ(24'000'000U, 250'000 * ((nbtp >> 16U & 0x1FFU) + 1) * quanta);
}

// NBTP read back as the manual writes it, against the clock: exact rate, sample point after CiA 301 table 1.
TEST(Can, ChangesToEveryBitRateOfCia305) {
  for (const std::uint32_t clock_Hz : {24'000'000U, 170'000'000U}) {
    SimCan sim;
    const CanBitTiming first = plan_can_timing(clock_Hz, 1'000'000);
    EXPECT_FALSE(sim.can->offers_bit_rate(250'000)) << "the clock is not known yet";
    ASSERT_EQ(sim.can->start(first, {}, clock_Hz), CanFault::kNone);
    const std::uint32_t filters = sim.registers.rxgfc.value;
    for (const std::uint32_t rate :
         {10'000U, 20'000U, 50'000U, 125'000U, 250'000U, 500'000U, 800'000U, 1'000'000U}) {
      if (clock_Hz % rate != 0) {
        EXPECT_FALSE(sim.can->offers_bit_rate(rate)) << rate;
        continue;
      }
      ASSERT_TRUE(sim.can->send(frame_of(0x123, {1})));
      ASSERT_TRUE(sim.can->set_bit_rate(rate)) << clock_Hz << ' ' << rate;
      EXPECT_TRUE(sim.transmit_queue.empty()) << "what waited is given up";
      const std::uint32_t nbtp = sim.registers.nbtp.value;
      const std::uint32_t segment_1 = (nbtp >> 8U & 0xFFU) + 1;
      const std::uint32_t quanta = 1 + segment_1 + (nbtp & 0x7FU) + 1;
      EXPECT_EQ(clock_Hz, rate * ((nbtp >> 16U & 0x1FFU) + 1) * quanta);
      EXPECT_GE((1 + segment_1) * 1000 / quanta, 750U) << rate;
      EXPECT_LE((1 + segment_1) * 1000, quanta * 875U) << rate;
      EXPECT_EQ(sim.registers.cccr.value, 0U) << "back on the bus";
      EXPECT_EQ(sim.registers.rxgfc.value, filters);
      sim.arrive(frame_of(0x321, {7}));
      CanFrame frame;
      ASSERT_TRUE(sim.can->receive(frame));
      EXPECT_EQ(frame.id, 0x321U);
    }
    const std::uint32_t before = sim.registers.nbtp.value;
    for (const std::uint32_t rate : {0U, 123'456U, 2'000'000U}) {
      EXPECT_FALSE(sim.can->set_bit_rate(rate));
      EXPECT_EQ(sim.registers.nbtp.value, before);
    }
    sim.answers = false;
    EXPECT_FALSE(sim.can->set_bit_rate(250'000));
  }
}

TEST(Can, SendsWhatItIsGiven) {
  SimCan sim;
  ASSERT_EQ(sim.start(), CanFault::kNone);
  std::mt19937 random(1);
  for (int i = 0; i < 2'000; ++i) {
    CanFrame frame;
    frame.extended = random() % 2 != 0;
    frame.remote = random() % 4 == 0;
    frame.id = static_cast<std::uint32_t>(random()) & (frame.extended ? 0x1FFFFFFFU : 0x7FFU);
    frame.length = static_cast<std::uint8_t>(random() % 9);
    for (auto& byte : frame.data) byte = static_cast<std::uint8_t>(random());
    ASSERT_TRUE(sim.can->send(frame));
    ASSERT_EQ(sim.transmitted(), frame);
  }
}

TEST(Can, PutsOffWhatTheFullFifoCannotTakeAndKeepsTheOrder) {
  SimCan sim;
  ASSERT_EQ(sim.start(), CanFault::kNone);
  for (std::uint8_t i = 0; i < 3; ++i) ASSERT_TRUE(sim.can->send(frame_of(0x100, {i})));
  EXPECT_FALSE(sim.can->send(frame_of(0x100, {3})));
  EXPECT_FALSE(sim.can->send(frame_of(0x100, {3})));
  EXPECT_EQ(sim.can->sends_put_off(), 2U);
  EXPECT_EQ(sim.transmitted(), frame_of(0x100, {0}));
  EXPECT_TRUE(sim.can->send(frame_of(0x100, {3})));
  for (std::uint8_t i = 1; i <= 3; ++i) EXPECT_EQ(sim.transmitted(), frame_of(0x100, {i}));
}

TEST(Can, RefusesWhatIsNoFrame) {
  SimCan sim;
  ASSERT_EQ(sim.start(), CanFault::kNone);
  CanFrame frame = frame_of(0x800, {});
  EXPECT_FALSE(sim.can->send(frame));
  frame.extended = true;
  EXPECT_TRUE(sim.can->send(frame));
  frame.id = 0x20000000;
  EXPECT_FALSE(sim.can->send(frame));
  frame = frame_of(1, {});
  frame.length = 9;
  EXPECT_FALSE(sim.can->send(frame));
  EXPECT_EQ(sim.can->frames_refused(), 3U);
  EXPECT_EQ(sim.transmit_queue.size(), 1U);
}

TEST(Can, ReceivesInOrderWhatItsFiltersAccept) {
  SimCan sim;
  // CANopen node 5: NMT and SYNC apart from SDO and RPDOs.
  ASSERT_EQ(sim.start({{.id = 0x000, .mask = 0x7FF, .fifo = 0},
                       {.id = 0x080, .mask = 0x7FF, .fifo = 0},
                       {.id = 0x605, .mask = 0x7FF, .fifo = 1},
                       {.id = 0x205, .mask = 0x6FF, .fifo = 1}}),
            CanFault::kNone);
  for (std::uint32_t id = 0; id < 0x800; ++id) {
    CanFrame out = frame_of(id, {static_cast<std::uint8_t>(id), 2, 3, 4, 5, 6, 7, 8});
    sim.arrive(out);
    CanFrame in;
    const bool wanted = id == 0 || id == 0x080 || id == 0x605 || id == 0x205 || id == 0x305;
    ASSERT_EQ(sim.can->receive(in), wanted) << std::hex << id;
    if (wanted) {
      ASSERT_EQ(in, out);
    }
    out.extended = true;
    sim.arrive(out);
    out.extended = false;
    out.remote = true;
    sim.arrive(out);
    ASSERT_FALSE(sim.can->receive(in)) << std::hex << id;
  }
  EXPECT_EQ(sim.fifo[0].taken, 2U);
  EXPECT_EQ(sim.fifo[1].taken, 3U);
}

TEST(Can, ReceivesEveryStandardFrameWithoutFilters) {
  SimCan sim;
  ASSERT_EQ(sim.start(), CanFault::kNone);
  CanFrame in;
  for (std::uint32_t id = 0; id < 0x800; ++id) {
    sim.arrive(frame_of(id, {1}));
    ASSERT_TRUE(sim.can->receive(in));
    ASSERT_EQ(in.id, id);
  }
  CanFrame extended = frame_of(3, {});
  extended.extended = true;
  sim.arrive(extended);
  EXPECT_FALSE(sim.can->receive(in));
}

TEST(Can, TakesLengthsBeyondEightAsEight) {
  SimCan sim;
  ASSERT_EQ(sim.start(), CanFault::kNone);
  CanFrame frame = frame_of(1, {1, 2, 3, 4, 5, 6, 7, 8});
  frame.length = 15;  // classic CAN allows the code
  sim.arrive(frame);
  CanFrame in;
  ASSERT_TRUE(sim.can->receive(in));
  EXPECT_EQ(in.length, 8);
  EXPECT_EQ(in.data[7], 8);
}

TEST(Can, CountsWhatAFullFifoLost) {
  SimCan sim;
  ASSERT_EQ(sim.start(), CanFault::kNone);
  sim.interrupts_by_hand = true;
  for (std::uint8_t i = 0; i < 5; ++i) sim.arrive(frame_of(7, {i}));
  sim.can->on_interrupt();
  EXPECT_EQ(sim.can->status().frames_lost, 1U) << "the part tells that frames were lost, not how many";
  CanFrame in;
  for (std::uint8_t i = 0; i < 3; ++i) {
    ASSERT_TRUE(sim.can->receive(in));
    EXPECT_EQ(in.data[0], i);
  }
  EXPECT_FALSE(sim.can->receive(in));
  EXPECT_EQ(sim.registers.ir.value, 0U);
  sim.can->on_interrupt();
  EXPECT_EQ(sim.can->status().frames_lost, 1U);
}

TEST(Can, CountsWhatAFullQueueLost) {
  SimCan sim;
  ASSERT_EQ(sim.start(), CanFault::kNone);
  for (std::uint8_t i = 0; i < 40; ++i) sim.arrive(frame_of(7, {i}));
  EXPECT_EQ(sim.can->status().frames_lost, 8U);
  CanFrame in;
  for (std::uint8_t i = 0; i < 32; ++i) {
    ASSERT_TRUE(sim.can->receive(in));
    EXPECT_EQ(in.data[0], i);
  }
  EXPECT_FALSE(sim.can->receive(in));
}

TEST(Can, TellsTheStateOfTheBus) {
  SimCan sim;
  ASSERT_EQ(sim.start(), CanFault::kNone);
  EXPECT_EQ(sim.can->status().state, CanBusState::kActive);
  sim.registers.ecr.value = 97U | 12U << 8U;
  sim.registers.psr.value = 1U << 6U;
  EXPECT_EQ(sim.can->status().state, CanBusState::kWarning);
  EXPECT_EQ(sim.can->status().transmit_errors, 97U);
  EXPECT_EQ(sim.can->status().receive_errors, 12U);
  sim.registers.psr.value = 1U << 6U | 1U << 5U;
  sim.registers.ecr.value = 128U | 127U << 8U | 1U << 15U;
  EXPECT_EQ(sim.can->status().state, CanBusState::kPassive);
  EXPECT_EQ(sim.can->status().receive_errors, 128U);
}

TEST(Can, LeavesBusOffOnlyWhenAsked) {
  SimCan sim;
  ASSERT_EQ(sim.start(), CanFault::kNone);
  sim.can->recover();
  EXPECT_EQ(sim.can->recoveries(), 0U) << "nothing to recover from";
  ASSERT_TRUE(sim.can->send(frame_of(1, {})));
  sim.bus_off = true;
  sim.registers.cccr.value |= 1U;  // the part itself
  sim.registers.ir.value |= 1U << 19U;
  sim.can->on_interrupt();
  EXPECT_EQ(sim.can->bus_offs(), 1U);
  EXPECT_EQ(sim.can->status().state, CanBusState::kOff);
  EXPECT_FALSE(sim.can->send(frame_of(1, {})));
  EXPECT_EQ(sim.registers.cccr.value & 1U, 1U);
  sim.can->recover();
  EXPECT_EQ(sim.registers.cccr.value & 1U, 0U);
  EXPECT_EQ(sim.cancelled, 7U) << "old frames must not leave late";
  EXPECT_EQ(sim.can->status().state, CanBusState::kActive);
  EXPECT_TRUE(sim.can->send(frame_of(1, {})));
  sim.registers.ir.value |= 1U << 19U;  // also raised on leaving
  sim.can->on_interrupt();
  EXPECT_EQ(sim.can->bus_offs(), 1U);
}

TEST(CanRing, KeepsOrderAcrossTheWrapOfItsIndices) {
  CanRing<4> ring;
  std::mt19937 random(2);
  std::deque<std::uint32_t> model;
  std::uint32_t next = 0;
  for (int i = 0; i < 10'000; ++i) {
    CanFrame frame;
    if (random() % 2 != 0) {
      frame.id = next;
      const bool pushed = ring.push(frame);
      ASSERT_EQ(pushed, model.size() < 4);
      if (pushed) model.push_back(next);
      ++next;
    } else {
      const bool popped = ring.pop(frame);
      ASSERT_EQ(popped, !model.empty());
      if (popped) {
        ASSERT_EQ(frame.id, model.front());
        model.pop_front();
      }
    }
  }
}

}  // namespace
}  // namespace slipstack::stm32g474
