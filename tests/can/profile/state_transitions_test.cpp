// SPDX-License-Identifier: Apache-2.0
// The power drive systems state machine of CiA 402 (IEC 61800-7-201, figure 2 and tables 28 to 30) at the
// node: the tables below are the standard's, the rest sends controlwords as frames and reads statuswords from
// frames.
#include <optional>
#include <string_view>

#include "tests/can/bench.h"

namespace slipstack::can {
namespace {

enum class State { kNotReady, kDisabled, kReady, kSwitchedOn, kEnabled, kQuickStop, kReaction, kFault };

// Statusword: the bits that tell a state.
struct StatusCoding {
  State state;
  const char* name;
  std::uint32_t mask;
  std::uint32_t bits;
};
constexpr StatusCoding kStatus[] = {
    {State::kNotReady, "not ready to switch on", 0x4F, 0x00},
    {State::kDisabled, "switch on disabled", 0x4F, 0x40},
    {State::kReady, "ready to switch on", 0x6F, 0x21},
    {State::kSwitchedOn, "switched on", 0x6F, 0x23},
    {State::kEnabled, "operation enabled", 0x6F, 0x27},
    {State::kQuickStop, "quick stop active", 0x6F, 0x07},
    {State::kReaction, "fault reaction active", 0x4F, 0x0F},
    {State::kFault, "fault", 0x4F, 0x08},
};
const char* name_of(State state) {
  return kStatus[static_cast<std::size_t>(state)].name;
}
std::optional<State> state_in(std::uint32_t statusword) {
  std::optional<State> found;
  for (const StatusCoding& row : kStatus) {
    if ((statusword & row.mask) != row.bits) continue;
    EXPECT_FALSE(found) << "two states in one statusword";
    found = row.state;
  }
  return found;
}

// Controlword: bits 7, 3, 2, 1, 0 of each command; x does not matter.
struct CommandCoding {
  const char* name;
  std::string_view bits;
};
constexpr CommandCoding kShutdown{"shutdown", "0x110"};
constexpr CommandCoding kSwitchOn{"switch on", "00111"};
constexpr CommandCoding kDisableVoltage{"disable voltage", "0xx0x"};
constexpr CommandCoding kQuickStop{"quick stop", "0x01x"};
constexpr CommandCoding kDisableOperation{"disable operation", "00111"};
constexpr CommandCoding kEnableOperation{"enable operation", "01111"};
constexpr CommandCoding kFaultReset{"fault reset", "1xxxx"};  // by the rising edge of bit 7
// Not one of the standard's commands but two at once: switched on on the way.
constexpr CommandCoding kSwitchOnAndEnable{"switch on and enable operation", "01111"};

bool is(const CommandCoding& command, std::uint32_t word) {
  constexpr int kBits[] = {7, 3, 2, 1, 0};
  for (std::size_t i = 0; i < command.bits.size(); ++i) {
    if (command.bits[i] != 'x' && (command.bits[i] == '1') != ((word >> kBits[i] & 1U) != 0)) return false;
  }
  return true;
}

// Transitions by command. Those by themselves and by events (0, 1, 12 at the end of the stop, 13, 14) have
// tests of their own.
enum class Option { kAny, kBrakeAndSwitchOff, kBrakeAndStay };  // quick stop option code 605Ah
struct Transition {
  int number;
  State from;
  CommandCoding command;
  State to;
  Option option = Option::kAny;
};
constexpr Transition kTransitions[] = {
    {2, State::kDisabled, kShutdown, State::kReady},
    {3, State::kReady, kSwitchOn, State::kSwitchedOn},
    {3, State::kReady, kSwitchOnAndEnable, State::kSwitchedOn},
    {4, State::kSwitchedOn, kEnableOperation, State::kEnabled},
    {5, State::kEnabled, kDisableOperation, State::kSwitchedOn},
    {6, State::kSwitchedOn, kShutdown, State::kReady},
    {7, State::kReady, kDisableVoltage, State::kDisabled},
    {7, State::kReady, kQuickStop, State::kDisabled},
    {8, State::kEnabled, kShutdown, State::kReady},
    {9, State::kEnabled, kDisableVoltage, State::kDisabled},
    {10, State::kSwitchedOn, kDisableVoltage, State::kDisabled},
    {10, State::kSwitchedOn, kQuickStop, State::kDisabled},
    {11, State::kEnabled, kQuickStop, State::kQuickStop},
    {12, State::kQuickStop, kDisableVoltage, State::kDisabled},
    {15, State::kFault, kFaultReset, State::kDisabled},
    {16, State::kQuickStop, kEnableOperation, State::kEnabled, Option::kBrakeAndStay},
};

// Where a word leads that is held: transition after transition, bit 7 rising at the first only.
State settled(State state, std::uint32_t word, Option option) {
  bool first = true;
  for (bool moved = true; moved; first = false) {
    moved = false;
    for (const Transition& row : kTransitions) {
      if (row.from != state || !is(row.command, word)) continue;
      if (row.option != Option::kAny && row.option != option) continue;
      if (row.command.bits == kFaultReset.bits && !first) continue;
      state = row.to;
      moved = true;
      break;
    }
  }
  return state;
}

// A bench whose states are reached and read by frames alone; faults come from the encoder and from the timer.
class Desk402 {
 public:
  explicit Desk402(bool rpdo, Option option = Option::kBrakeAndSwitchOff, bool model = true) : rpdo_(rpdo) {
    bench.write(0x605A, 0, option == Option::kBrakeAndStay ? 6 : 2, 2);
    bench.write(0x605C, 0, 0, 2);        // without a ramp: transition 5 at once
    bench.write_real(0x2000, 14, 1.0F);  // braking from 0.1 m/s shall take 100 ms
    if (model) bench.configure();
    // TPDO 1 shall report every change of the statusword: without inhibit time and event timer.
    EXPECT_EQ(bench.write(0x1800, 1, 0xC0000185, 4), 0U);
    EXPECT_EQ(bench.write(0x1800, 3, 0, 2), 0U);
    EXPECT_EQ(bench.write(0x1800, 5, 0, 2), 0U);
    EXPECT_EQ(bench.write(0x1800, 1, 0x40000185, 4), 0U);
    bench.nmt(0x01);
    bench.poll();
    bench.write(0x6060, 0, 1, 1);
  }

  void send(std::uint32_t word) {
    if (rpdo_) {
      bench.send(0x205, {static_cast<std::uint8_t>(word), static_cast<std::uint8_t>(word >> 8), 1});
      bench.poll();
    } else {
      ASSERT_EQ(bench.write(0x6040, 0, word, 2), 0U);
    }
  }
  void command(std::uint32_t word) {
    send(word);
    bench.run_ms(1);
  }
  State state() { return state_in(bench.read(0x6041, 0)).value_or(State::kNotReady); }
  /// The states that the statuswords of TPDO 1 tell, each once, while `ms` pass.
  std::vector<State> seen(int ms) {
    std::vector<State> states;
    bench.all();
    bench.run_ms(ms);
    for (const Data& data : bench.all_with(0x185)) {
      const State now = state_in(Bench::number(data, 0, 2)).value_or(State::kNotReady);
      if (states.empty() || states.back() != now) states.push_back(now);
    }
    return states;
  }

  void move() {
    const int way = position() > 150000 ? -60000 : 60000;
    bench.write(0x607A, 0, static_cast<std::uint32_t>(position() + way), 4);
    command(0x1F);
    bench.run_ms(150);
    ASSERT_GT(std::abs(bench.read_signed(0x606C, 0)), 90000);
  }
  std::int32_t position() { return bench.read_signed(0x6064, 0); }
  void late_tick() { bench.loop->clock.advance(2000); }
  void encoder(bool valid) { bench.loop->board_encoder.next.valid = valid; }

  /// From wherever it is.
  void bring_to(State wanted) {
    encoder(true);
    if (wanted == State::kNotReady) return;
    for (int i = 0; i < 400 && state() == State::kReaction; ++i) bench.run_ms(1);
    command(0x00);
    if (state() == State::kFault) {
      command(0x80);
      command(0x00);
    }
    bench.run_ms(150);  // coasts to rest
    if (wanted == State::kFault) {
      encoder(false);
      bench.run_ms(2);
      encoder(true);
      bench.run_ms(1);
    }
    const bool enabled =
        wanted == State::kEnabled || wanted == State::kQuickStop || wanted == State::kReaction;
    if (enabled || wanted == State::kReady || wanted == State::kSwitchedOn) command(0x06);
    if (enabled || wanted == State::kSwitchedOn) command(0x07);
    if (enabled) command(0x0F);
    if (enabled) move();  // at rest a quick stop would be over at once
    if (wanted == State::kQuickStop) command(0x0B);
    if (wanted == State::kReaction) {
      late_tick();
      bench.run_ms(1);
    }
    ASSERT_EQ(state(), wanted) << name_of(state()) << ", not " << name_of(wanted);
  }

  Bench bench;

 private:
  bool rpdo_;
};

struct Transport : ::testing::TestWithParam<bool> {};
INSTANTIATE_TEST_SUITE_P(By, Transport, ::testing::Bool(),
                         [](const auto& by) { return by.param ? "Rpdo" : "Sdo"; });

// Every command from every state: all 32 words of the bits that count, the others (mode, halt, maker's) clear
// and set. What has no row in the table must not move the state.
TEST_P(Transport, EveryWordFromEveryStateDoesWhatTheStandardsTableSays) {
  int taken = 0;
  int refused = 0;
  for (const Option option : {Option::kBrakeAndSwitchOff, Option::kBrakeAndStay}) {
    Desk402 desk(GetParam(), option);
    Desk402 bare(GetParam(), option, false);
    for (const StatusCoding& from : kStatus) {
      if (option == Option::kBrakeAndStay && from.state != State::kQuickStop) continue;
      Desk402& at = from.state == State::kNotReady ? bare : desk;
      for (std::uint32_t i = 0; i < 32; ++i) {
        for (const std::uint32_t others : {0x0000U, 0xF960U}) {
          const std::uint32_t word = (i & 0x0FU) | (i & 0x10U) << 3 | others;
          at.bring_to(from.state);
          ASSERT_FALSE(HasFatalFailure());
          // Bit 7 shall rise; a held word 0 would have been a command already.
          at.command(word);
          State expected = settled(from.state, word, option);
          // The standard's commands have bit 7 clear. With it set nothing may come nearer to moving, but this
          // drive follows what takes the current away.
          if ((word & 0x80U) != 0 && from.state != State::kFault) {
            const State without = settled(from.state, word & ~0x80U, option);
            const bool down = without < from.state && without != State::kEnabled;
            if (down || without == State::kQuickStop) expected = without;
          }
          EXPECT_EQ(at.state(), expected) << name_of(from.state) << ", controlword " << std::hex << word
                                          << ": " << name_of(at.state()) << ", not " << name_of(expected);
          ++(expected == from.state ? refused : taken);
        }
      }
    }
  }
  EXPECT_EQ(taken + refused, 9 * 64);
  EXPECT_GT(taken, 150);
  EXPECT_GT(refused, 250);
}

// Each transition by the plainest word of its command, watched in the statuswords that TPDO 1 sends by
// itself.
TEST_P(Transport, EachTransitionIsToldByTheStatusword) {
  std::array<int, 17> seen{};
  for (const Transition& row : kTransitions) {
    SCOPED_TRACE(testing::Message() << "transition " << row.number << ", " << row.command.name);
    Desk402 desk(GetParam(), row.option);
    desk.bring_to(row.from);
    ASSERT_FALSE(HasFatalFailure());
    std::uint32_t word = 0;
    constexpr int kBits[] = {7, 3, 2, 1, 0};
    for (std::size_t i = 0; i < row.command.bits.size(); ++i) {
      if (row.command.bits[i] == '1') word |= 1U << kBits[i];
    }
    desk.send(word);
    std::vector<State> states = desk.seen(1);
    ASSERT_FALSE(states.empty());
    if (row.command.name == kSwitchOnAndEnable.name) {
      EXPECT_EQ(states.back(), State::kEnabled);
    } else {
      EXPECT_EQ(states.back(), row.to) << name_of(states.back());
    }
    EXPECT_EQ(desk.bench.loop->motor.enabled,
              states.back() == State::kEnabled || states.back() == State::kQuickStop);
    ++seen[static_cast<std::size_t>(row.number)];
  }
  for (const int number : {2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 15, 16})
    EXPECT_GT(seen[static_cast<std::size_t>(number)], 0);
}

// 0 and 1: by themselves, as soon as there is something to control; no command does it.
TEST_P(Transport, NotReadyIsLeftByItself) {
  Desk402 desk(GetParam(), Option::kAny, false);
  EXPECT_EQ(desk.state(), State::kNotReady);
  EXPECT_FALSE(desk.bench.loop->motor.enabled);
  desk.command(0x0F);
  EXPECT_EQ(desk.state(), State::kNotReady);
  desk.command(0x00);
  desk.bench.configure();
  EXPECT_EQ(desk.state(), State::kDisabled);
}

// 12, at the end of the stop (option 2); option 6 stays and holds; option 0 does not brake.
TEST_P(Transport, QuickStopEndsByItsOptionCode) {
  for (const Option option : {Option::kBrakeAndSwitchOff, Option::kBrakeAndStay}) {
    Desk402 desk(GetParam(), option);
    desk.bring_to(State::kQuickStop);
    const std::vector<State> states = desk.seen(300);
    if (option == Option::kBrakeAndStay) {
      EXPECT_EQ(desk.state(), State::kQuickStop);
      EXPECT_TRUE(desk.bench.loop->motor.enabled);
      const std::int32_t place = desk.position();
      desk.bench.run_ms(3000);  // longer than a stop may take: nothing times out
      EXPECT_NEAR(desk.position(), place, 5);
      EXPECT_EQ(desk.state(), State::kQuickStop);
      desk.command(0x0F);  // 16
      EXPECT_EQ(desk.state(), State::kEnabled);
      EXPECT_NEAR(desk.position(), place, 5);
      desk.move();  // and it works again
    } else {
      ASSERT_FALSE(states.empty());
      EXPECT_EQ(states.back(), State::kDisabled);
      EXPECT_FALSE(desk.bench.loop->motor.enabled);
      EXPECT_NEAR(desk.bench.read_signed(0x606C, 0), 0, 2000);
    }
  }
  Desk402 desk(GetParam());
  ASSERT_EQ(desk.bench.write(0x605A, 0, 0, 2), 0U);
  desk.bring_to(State::kEnabled);
  desk.command(0x0B);
  EXPECT_EQ(desk.state(), State::kDisabled);
  EXPECT_FALSE(desk.bench.loop->motor.enabled);
  EXPECT_GT(std::abs(desk.bench.read_signed(0x606C, 0)), 20000) << "not braked";
}

// 16 while the axis still brakes: it comes to rest and holds, under the reference.
TEST_P(Transport, EnabledAgainWhileBrakingTheAxisComesToRest) {
  Desk402 desk(GetParam(), Option::kBrakeAndStay);
  desk.bring_to(State::kQuickStop);
  desk.command(0x0F);
  EXPECT_EQ(desk.state(), State::kEnabled);
  EXPECT_GT(std::abs(desk.bench.read_signed(0x606C, 0)), 50000);
  desk.bench.run_ms(300);
  EXPECT_NEAR(desk.bench.read_signed(0x606C, 0), 0, 1500);
  EXPECT_EQ(desk.state(), State::kEnabled);
}

// 13 from every state, through the fault reaction (14): braked where the position is still known, and the
// reaction seen; else both within one tick.
TEST_P(Transport, AFaultFromEveryState) {
  for (const State from :
       {State::kDisabled, State::kReady, State::kSwitchedOn, State::kEnabled, State::kQuickStop}) {
    for (const bool position_known : {true, false}) {
      SCOPED_TRACE(testing::Message()
                   << name_of(from) << (position_known ? ", late tick" : ", encoder lost"));
      Desk402 desk(GetParam());
      desk.bring_to(from);
      ASSERT_FALSE(HasFatalFailure());
      if (position_known) {
        desk.late_tick();
      } else {
        desk.encoder(false);
      }
      const std::vector<State> states = desk.seen(300);
      const bool driving = from == State::kEnabled || from == State::kQuickStop;
      EXPECT_FALSE(desk.bench.loop->motor.enabled);
      if (position_known && !driving) {
        EXPECT_TRUE(states.empty()) << "a late tick without current is counted, and no fault";
        EXPECT_GT(desk.bench.read(0x2210, 3), 0U);
        continue;
      }
      const std::vector<State> reaction{State::kReaction, State::kFault};
      EXPECT_EQ(states, position_known ? reaction : std::vector<State>{State::kFault});
      EXPECT_EQ(desk.bench.read(0x603F, 0), position_known ? 0x6101U : 0x7305U);
    }
  }
  Desk402 bare(GetParam(), Option::kAny, false);
  bare.bench.loop->controller().inject(Fault::kWatchdog);
  bare.bench.run_ms(1);
  EXPECT_EQ(bare.state(), State::kFault) << "from not ready";
}

// 15: by the edge alone, and not while what raised the fault lasts.
TEST_P(Transport, AFaultIsAcknowledgedByARisingEdgeWhenItIsOver) {
  Desk402 desk(GetParam());
  desk.bring_to(State::kReady);
  desk.encoder(false);
  desk.bench.run_ms(1);
  desk.command(0x80);
  EXPECT_EQ(desk.state(), State::kFault) << "the cause is there";
  desk.encoder(true);
  desk.command(0x80);
  EXPECT_EQ(desk.state(), State::kFault) << "no edge";
  desk.command(0x00);
  EXPECT_EQ(desk.state(), State::kFault) << "a falling edge";
  desk.command(0x8F);
  EXPECT_EQ(desk.state(), State::kDisabled);
  desk.command(0x8F);
  EXPECT_EQ(desk.state(), State::kDisabled) << "nothing else by the same word";
  desk.encoder(false);
  desk.bench.run_ms(1);
  desk.encoder(true);
  desk.command(0x8F);
  EXPECT_EQ(desk.state(), State::kFault) << "bit 7 was set before the fault";
}

// A fault before there is a model, acknowledged: no state in which current could flow is reached without one.
TEST_P(Transport, WithoutAModelNothingIsSwitchedOn) {
  Desk402 desk(GetParam(), Option::kAny, false);
  desk.bench.loop->controller().inject(Fault::kWatchdog);
  desk.bench.run_ms(1);
  desk.command(0x80);
  EXPECT_EQ(desk.state(), State::kDisabled);
  for (const std::uint32_t word : {0x06U, 0x07U, 0x0FU}) {
    desk.command(word);
    EXPECT_EQ(desk.state(), State::kDisabled);
  }
  EXPECT_FALSE(desk.bench.loop->motor.enabled);
  desk.command(0x00);
  desk.bench.configure();
  desk.command(0x06);
  EXPECT_EQ(desk.state(), State::kReady);
}

TEST(QuickStopOption, OnlyWhatIsOfferedIsTaken) {
  Bench bench;
  for (std::uint32_t code = 0; code < 8; ++code) {
    const bool offered = code <= 2 || code == 5 || code == 6;
    EXPECT_EQ(bench.write(0x605A, 0, code, 2) == 0, offered) << code;
  }
}

}  // namespace
}  // namespace slipstack::can
