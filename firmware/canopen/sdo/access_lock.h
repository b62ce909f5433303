// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <bit>
#include <cstdint>

namespace slipstack::canopen {

/// SipHash-2-4 of one 8-byte block (Aumasson, Bernstein 2012): a keyed checksum, 64 bits, without tables or
/// branches on the key.
constexpr std::uint64_t siphash(std::uint64_t k0, std::uint64_t k1, std::uint64_t message) {
  std::uint64_t v0 = k0 ^ 0x736F6D6570736575U;
  std::uint64_t v1 = k1 ^ 0x646F72616E646F6DU;
  std::uint64_t v2 = k0 ^ 0x6C7967656E657261U;
  std::uint64_t v3 = k1 ^ 0x7465646279746573U;
  const auto rounds = [&](int count) {
    for (int i = 0; i < count; ++i) {
      v0 += v1;
      v1 = std::rotl(v1, 13) ^ v0;
      v0 = std::rotl(v0, 32);
      v2 += v3;
      v3 = std::rotl(v3, 16) ^ v2;
      v0 += v3;
      v3 = std::rotl(v3, 21) ^ v0;
      v2 += v1;
      v1 = std::rotl(v1, 17) ^ v2;
      v2 = std::rotl(v2, 32);
    }
  };
  for (const std::uint64_t word : {message, std::uint64_t{8} << 56}) {  // the second holds the length
    v3 ^= word;
    rounds(2);
    v0 ^= word;
  }
  v2 ^= 0xFF;
  rounds(4);
  return v0 ^ v1 ^ v2 ^ v3;
}

/// Challenge and response over a shared key. Opens for writing after the right response; closes again when
/// asked, at a reset, or when the node loses its master. After a wrong response the next is looked at only
/// after a wait that doubles each time.
class AccessLock {
 public:
  using Key = std::array<std::uint32_t, 4>;
  static constexpr std::uint32_t kFirstWait_us = 1'000'000;
  static constexpr std::uint32_t kDoublings = 9;  ///< the longest wait is 512 s

  enum class State : std::uint8_t { kOff, kLocked, kOpen };

  void set_in_use(bool used) {
    in_use_ = used;
    open_ = false;
  }
  State state() const { return !in_use_ ? State::kOff : (open_ ? State::kOpen : State::kLocked); }
  bool allows_writing() const { return !in_use_ || open_; }
  void close() { open_ = false; }

  /// A new challenge; the one before is void. `entropy` is mixed in: arrival times, counters.
  std::uint64_t challenge(const Key& key, std::uint64_t entropy) {
    pool_ = siphash(low(key) ^ pool_, high(key) ^ ++drawn_, entropy);
    challenge_ = pool_;
    pending_ = true;
    return challenge_;
  }
  std::uint64_t last_challenge() const { return challenge_; }

  /// True: open now. Each challenge is good for one try. While waiting nothing is compared.
  bool respond(const Key& key, std::uint64_t response, std::uint32_t now_us) {
    if (wrong_ > 0 && now_us - wrong_at_us_ < wait_us()) return false;
    const std::uint64_t difference = siphash(low(key), high(key), challenge_) ^ response;
    const bool right = pending_ && difference == 0;  // all 64 bits at once: the time reveals nothing
    pending_ = false;
    if (right) {
      open_ = true;
      wrong_ = 0;
      return true;
    }
    wrong_at_us_ = now_us;
    if (wrong_ <= kDoublings) ++wrong_;
    return false;
  }
  std::uint32_t wait_us() const { return wrong_ == 0 ? 0 : kFirstWait_us << (wrong_ - 1); }

 private:
  static std::uint64_t low(const Key& key) { return key[0] | (static_cast<std::uint64_t>(key[1]) << 32); }
  static std::uint64_t high(const Key& key) { return key[2] | (static_cast<std::uint64_t>(key[3]) << 32); }

  bool in_use_ = false;
  bool open_ = false;
  bool pending_ = false;
  std::uint64_t challenge_ = 0;
  std::uint64_t pool_ = 0;
  std::uint64_t drawn_ = 0;
  std::uint32_t wrong_ = 0;
  std::uint32_t wrong_at_us_ = 0;
};

}  // namespace slipstack::canopen
