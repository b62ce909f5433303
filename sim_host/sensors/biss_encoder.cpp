// SPDX-License-Identifier: Apache-2.0
#include "sim_host/sensors/biss_encoder.h"

#include <cstddef>

namespace slipstack::sim {
namespace {

// Long division of the bits, with six zeros behind them, by 1000011.
std::vector<bool> remainder_of(std::vector<bool> bits) {
  const std::vector<bool> divisor = {true, false, false, false, false, true, true};
  const std::size_t data = bits.size();
  bits.resize(data + 6, false);
  for (std::size_t i = 0; i < data; ++i) {
    if (!bits[i]) continue;
    for (std::size_t k = 0; k < divisor.size(); ++k) bits[i + k] = bits[i + k] != divisor[k];
  }
  return {bits.end() - 6, bits.end()};
}

}  // namespace

std::vector<std::uint8_t> BissEncoder::cycle(std::uint64_t position, const Fault& fault, int bytes) const {
  std::vector<bool> checked;
  for (int bit = setup_.bits - 1; bit >= 0; --bit) checked.push_back((position >> bit & 1U) != 0);
  checked.push_back(!fault.error);
  checked.push_back(!fault.warning);
  std::vector<bool> frame = {true, false};  // start, CDS
  frame.insert(frame.end(), checked.begin(), checked.end());
  for (const bool bit : remainder_of(checked)) frame.push_back(!bit);
  if (fault.flipped) {
    const auto at = static_cast<std::size_t>(*fault.flipped) + 1;
    frame.at(at) = !frame.at(at);
  }
  if (fault.ends_at) frame.resize(static_cast<std::size_t>(*fault.ends_at) + 1);

  std::vector<bool> line(std::size_t{1} + static_cast<std::size_t>(setup_.delay_clocks), true);
  line.insert(line.end(), static_cast<std::size_t>(setup_.processing_clocks), false);
  line.insert(line.end(), frame.begin(), frame.end());
  line.resize(std::size_t{8} * static_cast<std::size_t>(bytes), false);
  if (fault.unplugged) line.assign(line.size(), true);
  if (fault.short_circuit) line.assign(line.size(), false);

  std::vector<std::uint8_t> sampled(static_cast<std::size_t>(bytes), 0);
  for (std::size_t i = 0; i < line.size(); ++i) {
    if (line[i]) sampled[i / 8] = static_cast<std::uint8_t>(sampled[i / 8] | 0x80U >> i % 8);
  }
  return sampled;
}

}  // namespace slipstack::sim
