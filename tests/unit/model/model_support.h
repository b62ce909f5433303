// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <unistd.h>

#include <cmath>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <random>
#include <stdexcept>
#include <string>
#include <string_view>

#include "firmware/effects/presliding_hysteresis.h"
#include "workbench/base/errors.h"
#include "workbench/model/model.h"

namespace slipstack::workbench::test {

/// A temporary file, removed after the test.
class TemporaryFile {
 public:
  TemporaryFile() {
    std::string name = (std::filesystem::temp_directory_path() / "slipstack_model_XXXXXX").string();
    if (::mkdtemp(name.data()) == nullptr) throw std::runtime_error("no temporary directory");
    directory_ = name;
  }
  ~TemporaryFile() {
    std::error_code ignored;
    std::filesystem::remove_all(directory_, ignored);
  }
  TemporaryFile(const TemporaryFile&) = delete;
  TemporaryFile& operator=(const TemporaryFile&) = delete;

  const std::filesystem::path& directory() const { return directory_; }
  std::filesystem::path path() const { return directory_ / "model.toml"; }
  std::filesystem::path write(std::string_view content) const {
    // A new file each time: file systems flush a file that is truncated and written again, which is slow.
    std::filesystem::remove(path());
    std::ofstream file(path(), std::ios::binary | std::ios::trunc);
    file.write(content.data(), static_cast<std::streamsize>(content.size()));
    return path();
  }

 private:
  std::filesystem::path directory_;
};

/// A term with random values inside all bounds; of the hysteresis, `elements` are used.
inline Term random_term(const EffectDescription& effect, std::mt19937_64& random, std::size_t elements,
                        bool with_errors) {
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  const auto between = [&](double low, double high) {
    // Bounds reach from 1e-7 to 1e12: numbers of every size must survive.
    if (low > 0.0) return low * std::pow(high / low, unit(random));
    const double value = std::pow(10.0, 18.0 * unit(random) - 6.0);
    return std::clamp(low < 0.0 && unit(random) < 0.5 ? -value : value, low, high);
  };
  Term term;
  term.effect = &effect;
  const bool hysteresis = term.id() == "presliding_hysteresis";
  for (std::size_t i = 0; i < effect.shapes.size(); ++i) {
    const ShapeSpec& spec = effect.shapes[i];
    const bool used = !hysteresis || i < elements;
    term.shapes.push_back(!used ? 0.0
                          : hysteresis
                              ? 1e-6 * std::pow(1.3, static_cast<double>(i))
                              : between(static_cast<double>(spec.lower), static_cast<double>(spec.upper)));
  }
  // The slip distances are a grid, not fitted.
  if (with_errors && !hysteresis) {
    for (std::size_t i = 0; i < effect.shapes.size(); ++i) term.shape_standard_errors.push_back(unit(random));
  }
  std::size_t index = 0;
  for (const GainGroup& group : effect.gain_groups) {
    for (int i = 0; i < group.count; ++i, ++index) {
      const bool used = !hysteresis || index < elements;
      const auto low = static_cast<double>(group.lower);
      const auto high = static_cast<double>(group.upper);
      term.gains.push_back(used ? between(low, high) : 0.0);
      term.lower.push_back(low);
      term.upper.push_back(high);
      if (with_errors) term.gain_standard_errors.push_back(used ? unit(random) : 0.0);
    }
  }
  return term;
}

/// A model of every effect.
inline Model full_model(std::uint64_t seed) {
  std::mt19937_64 random(seed);
  Model model;
  model.source = {"logs/axis 1 \"cold\".csv", 120'000, 0.1234567890123, 0.1, 3.0e-2};
  for (const EffectDescription& effect : catalogue()) {
    model.terms.push_back(random_term(effect, random, 28, true));
    model.target_terms.push_back(random_term(effect, random, kTargetElements, seed % 2 == 0));
  }
  model.target_holdout_rmse_N = 0.2;
  return model;
}

/// The message of read_model() for a text; empty where it is accepted. Exceptions other than InputError pass
/// through.
inline std::string refusal(const std::filesystem::path& path) {
  try {
    static_cast<void>(read_model(path));
    return {};
  } catch (const InputError& error) {
    return error.what();
  }
}

}  // namespace slipstack::workbench::test
