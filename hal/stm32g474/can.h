// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstdint>
#include <span>

#include "hal/include/can_port.h"
#include "hal/stm32g474/can_ring.h"
#include "hal/stm32g474/can_timing.h"
#include "hal/stm32g474/registers.h"

// FDCAN1 as a classic CAN port. RM0440, FD controller area network (FDCAN): modes, message RAM, acceptance
// filter, Rx and Tx handling.
namespace slipstack::stm32g474 {

enum class CanFault : std::uint8_t { kNone, kBadTiming, kTooManyFilters, kBadFilter, kNoAnswer };

// Frames with 11-bit identifiers for which (identifier & mask) == (id & mask) are received, into FIFO 0 or 1.
// Each FIFO holds three frames until the interrupt has taken them: what must not be lost behind a burst gets
// a FIFO of its own.
struct CanFilter {
  std::uint32_t id = 0;
  std::uint32_t mask = 0;
  std::uint32_t fifo = 0;
};

// Elements of the message RAM (RM0440, FDCAN Rx buffer and FIFO element, Tx buffer element, standard message
// ID filter element).
namespace can_element {
inline constexpr std::uint32_t kExtended = 1U << 30;
inline constexpr std::uint32_t kRemote = 1U << 29;
inline constexpr std::uint32_t kStandardIdShift = 18;
inline constexpr std::uint32_t kLengthShift = 16;
inline constexpr std::uint32_t kFilterClassic = 2U << 30;  // SFT: identifier and mask
inline constexpr std::uint32_t kFilterToFifo0 = 1U << 27;  // SFEC; twice that: FIFO 1
inline constexpr std::uint32_t kMaxStandardId = 0x7FF;
inline constexpr std::uint32_t kMaxExtendedId = 0x1FFF'FFFF;
}  // namespace can_element

// Registers: Fdcan<Word>, Ram: CanMessageRam<Word>. on_interrupt() belongs into the handler of FDCAN1_IT0,
// everything else into the main loop, at a lower priority.
template <class Registers, class Ram>
class Can final : public CanPort {
 public:
  static constexpr std::uint32_t kReceiveFrames = 32;

  Can(Registers& registers, Ram& ram) : can_(registers), ram_(ram) {}

  // Sets the port up and joins the bus, now or with set_bit_rate() once the rate is known: a node at a wrong
  // rate disturbs the others. Without filters, every data frame with an 11-bit identifier is
  // received, into FIFO 0; with filters, only what they accept. Frames with 29-bit identifiers and remote
  // requests are not: CANopen needs neither. The clock of the FDCAN must be running, and not above the bus
  // clock; where it is given, the bit rate can be changed later.
  [[nodiscard]] CanFault start(const CanBitTiming& timing, std::span<const CanFilter> filters,
                               std::uint32_t clock_Hz = 0, bool joins = true) {
    if (!timing.valid()) return CanFault::kBadTiming;
    if (filters.size() > kCanStandardFilters) return CanFault::kTooManyFilters;
    for (const CanFilter& filter : filters) {
      if (filter.id > can_element::kMaxStandardId || filter.mask > can_element::kMaxStandardId ||
          filter.fifo > 1) {
        return CanFault::kBadFilter;
      }
    }
    clock_Hz_ = clock_Hz;
    if (!configure(timing)) return CanFault::kNoAnswer;
    write_filters(filters);
    can_.txbc = kFDCAN_TXBC_TFQM(0);  // FIFO: frames leave in the order they came
    can_.ir = 0xFFFFFFFF;             // clears by writing 1
    can_.ie =
        kFDCAN_IE_RF0NE(1) | kFDCAN_IE_RF1NE(1) | kFDCAN_IE_RF0LE(1) | kFDCAN_IE_RF1LE(1) | kFDCAN_IE_BOE(1);
    can_.ils = 0;  // all on line 0
    can_.ile = kFDCAN_ILE_EINT0(1);
    return !joins || join() ? CanFault::kNone : CanFault::kNoAnswer;
  }

  // The rates at which the clock gives exact bits with a sample point as CiA 301 wants it.
  bool offers_bit_rate(std::uint32_t bits_per_s) const override {
    return bits_per_s <= 1'000'000 && clock_Hz_ != 0 && plan_can_timing(clock_Hz_, bits_per_s).valid();
  }
  // What has been received stays; filters and interrupts too.
  bool set_bit_rate(std::uint32_t bits_per_s) override {
    if (!offers_bit_rate(bits_per_s)) return false;
    const CanBitTiming timing = plan_can_timing(clock_Hz_, bits_per_s);
    can_.txbcr = kFDCAN_TXBCR_CR(7);
    const bool configured = configure(timing);
    return join() && configured;
  }

  // Queues a frame in the transmit FIFO, which holds three. False: the FIFO is full, the bus is off, or it is
  // no CAN frame (identifier or length too large).
  bool send(const CanFrame& frame) override {
    const std::uint32_t highest = frame.extended ? can_element::kMaxExtendedId : can_element::kMaxStandardId;
    if (frame.id > highest || frame.length > 8) {
      ++frames_refused_;
      return false;
    }
    const std::uint32_t status = can_.txfqs;
    if ((can_.psr & kFDCAN_PSR_BO.mask) != 0 || (status & kFDCAN_TXFQS_TFQF.mask) != 0) {
      ++sends_put_off_;
      return false;
    }
    const std::uint32_t slot = kFDCAN_TXFQS_TFQPI.read(status);
    if (slot >= kCanFifoElements) return false;
    auto& element = ram_.tx_buffers[slot];
    element.header[0] =
        (frame.extended ? can_element::kExtended | frame.id : frame.id << can_element::kStandardIdShift) |
        (frame.remote ? can_element::kRemote : 0U);
    element.header[1] = std::uint32_t{frame.length} << can_element::kLengthShift;
    // The message RAM takes whole words only.
    element.data[0] = word_of(frame, 0);
    element.data[1] = word_of(frame, 4);
    can_.txbar = 1U << slot;
    return true;
  }

  // Takes the oldest frame that the interrupt has fetched.
  bool receive(CanFrame& frame) override { return received_.pop(frame); }

  CanBusStatus status() const override {
    const std::uint32_t protocol = can_.psr;
    const std::uint32_t counters = can_.ecr;
    CanBusStatus status;
    if ((protocol & kFDCAN_PSR_BO.mask) != 0) {
      status.state = CanBusState::kOff;
    } else if ((protocol & kFDCAN_PSR_EP.mask) != 0) {
      status.state = CanBusState::kPassive;
    } else if ((protocol & kFDCAN_PSR_EW.mask) != 0) {
      status.state = CanBusState::kWarning;
    }
    status.transmit_errors = static_cast<std::uint16_t>(kFDCAN_ECR_TEC.read(counters));
    // REC stops at 127; RP is set beyond that.
    const bool passive = (counters & kFDCAN_ECR_RP.mask) != 0;
    status.receive_errors = static_cast<std::uint16_t>(passive ? 128U : kFDCAN_ECR_REC.read(counters));
    status.frames_lost = frames_lost_.load(std::memory_order_relaxed);
    return status;
  }

  // In bus-off the part has set INIT; taking it away starts the count of 129 x 11 recessive bits. Frames that
  // waited for transmission are given up: their time has passed.
  void recover() override {
    if ((can_.psr & kFDCAN_PSR_BO.mask) == 0) return;
    can_.txbcr = kFDCAN_TXBCR_CR(7);
    clear_bits(can_.cccr, kFDCAN_CCCR_INIT.mask);
    ++recoveries_;
  }

  // Fetches what has come in. At most the six frames that the FIFOs hold.
  void on_interrupt() {
    const std::uint32_t flags = can_.ir;
    can_.ir = flags;  // before the FIFOs are read: a frame that comes in meanwhile raises the flag again
    if ((flags & kFDCAN_IR_BO.mask) != 0 && (can_.psr & kFDCAN_PSR_BO.mask) != 0) count(bus_offs_);
    if ((flags & kFDCAN_IR_RF0L.mask) != 0) count(frames_lost_);
    if ((flags & kFDCAN_IR_RF1L.mask) != 0) count(frames_lost_);
    drain(0, can_.rxf0s, can_.rxf0a);
    drain(1, can_.rxf1s, can_.rxf1a);
  }

  // Counted since power-up.
  std::uint32_t bus_offs() const { return bus_offs_.load(std::memory_order_relaxed); }
  std::uint32_t recoveries() const { return recoveries_; }
  std::uint32_t sends_put_off() const { return sends_put_off_; }    // full or bus-off
  std::uint32_t frames_refused() const { return frames_refused_; }  // no CAN frames

 private:
  static constexpr std::uint32_t kPolls = 100'000;  // INIT follows within a frame, 130 us at 1 Mbit/s

  static std::uint32_t word_of(const CanFrame& frame, std::size_t at) {
    return std::uint32_t{frame.data[at]} | std::uint32_t{frame.data[at + 1]} << 8U |
           std::uint32_t{frame.data[at + 2]} << 16U | std::uint32_t{frame.data[at + 3]} << 24U;
  }

  // Leaves the bus, and writes what may change only in INIT with CCE. The rest of CCCR is 0: classic frames,
  // retransmission on.
  bool configure(const CanBitTiming& timing) {
    can_.cccr = kFDCAN_CCCR_INIT(1);
    if (!wait_for(can_.cccr, kFDCAN_CCCR_INIT.mask, kFDCAN_CCCR_INIT.mask, kPolls)) return false;
    can_.cccr = kFDCAN_CCCR_INIT(1) | kFDCAN_CCCR_CCE(1);
    can_.nbtp = kFDCAN_NBTP_NSJW.place(timing.jump_width - 1) | kFDCAN_NBTP_NBRP.place(timing.prescaler - 1) |
                kFDCAN_NBTP_NTSEG1.place(timing.segment_1 - 1) |
                kFDCAN_NBTP_NTSEG2.place(timing.segment_2 - 1);
    return true;
  }
  bool join() {
    clear_bits(can_.cccr, kFDCAN_CCCR_INIT.mask);
    return wait_for(can_.cccr, kFDCAN_CCCR_INIT.mask, 0, kPolls);
  }

  void write_filters(std::span<const CanFilter> filters) {
    for (std::size_t i = 0; i < kCanStandardFilters; ++i) ram_.standard_filters[i] = 0;  // disabled
    for (std::size_t i = 0; i < filters.size(); ++i) {
      ram_.standard_filters[i] = can_element::kFilterClassic |
                                 can_element::kFilterToFifo0 << filters[i].fifo | filters[i].id << 16U |
                                 filters[i].mask;
    }
    // A full FIFO keeps what it has (F0OM, F1OM = 0): the newest is lost and flagged, the order stays.
    const std::uint32_t others = filters.empty() ? kFDCAN_RXGFC_ANFS(0) : kFDCAN_RXGFC_ANFS(2);
    can_.rxgfc = kFDCAN_RXGFC_LSS.place(static_cast<std::uint32_t>(filters.size())) | kFDCAN_RXGFC_LSE(0) |
                 others | kFDCAN_RXGFC_ANFE(2) | kFDCAN_RXGFC_RRFS(1) | kFDCAN_RXGFC_RRFE(1);
  }

  template <class Word>
  void drain(std::size_t fifo, Word& status_register, Word& acknowledge_register) {
    for (std::size_t turn = 0; turn < kCanFifoElements; ++turn) {
      const std::uint32_t status = status_register;  // FIFO 1 has the same fields
      if (kFDCAN_RXF0S_F0FL.read(status) == 0) return;
      const std::uint32_t slot = kFDCAN_RXF0S_F0GI.read(status);
      if (slot >= kCanFifoElements) return;
      if (!received_.push(frame_in(ram_.rx_fifo[fifo][slot]))) count(frames_lost_);
      acknowledge_register = slot;
    }
  }

  template <class Element>
  static CanFrame frame_in(Element& element) {
    const std::uint32_t header = element.header[0];
    const std::uint32_t length = (element.header[1] >> can_element::kLengthShift) & 0xFU;
    CanFrame frame;
    frame.extended = (header & can_element::kExtended) != 0;
    frame.remote = (header & can_element::kRemote) != 0;
    frame.id = frame.extended ? header & can_element::kMaxExtendedId
                              : (header >> can_element::kStandardIdShift) & can_element::kMaxStandardId;
    frame.length = static_cast<std::uint8_t>(length > 8 ? 8 : length);  // 9 ... 15 mean 8 in classic CAN
    const std::uint32_t words[2] = {element.data[0], element.data[1]};
    for (std::size_t i = 0; i < frame.length; ++i) {
      frame.data[i] = static_cast<std::uint8_t>(words[i / 4] >> (8 * (i % 4)));
    }
    return frame;
  }

  // Written by the interrupt alone, read by the main loop; stays at its largest value.
  static void count(std::atomic<std::uint32_t>& counter) {
    const std::uint32_t value = counter.load(std::memory_order_relaxed);
    if (value != 0xFFFFFFFF) counter.store(value + 1, std::memory_order_relaxed);
  }

  Registers& can_;
  Ram& ram_;
  CanRing<kReceiveFrames> received_;
  std::atomic<std::uint32_t> frames_lost_{0};
  std::atomic<std::uint32_t> bus_offs_{0};
  std::uint32_t clock_Hz_ = 0;  // 0: not given
  std::uint32_t recoveries_ = 0;
  std::uint32_t sends_put_off_ = 0;
  std::uint32_t frames_refused_ = 0;
};

}  // namespace slipstack::stm32g474
