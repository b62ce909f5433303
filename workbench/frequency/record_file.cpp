// SPDX-License-Identifier: Apache-2.0
#include "workbench/frequency/record_file.h"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <fstream>
#include <map>

#include "workbench/base/errors.h"
#include "workbench/base/text.h"

namespace slipstack::workbench {
namespace {

constexpr const char* kColumns = "band,capture,position_m,force_N,excitation";

struct HeaderNumber {
  const char* key;
  double DriveController::*member;
};
constexpr std::array kNumbers{
    HeaderNumber{"tick_s", &DriveController::tick_s},
    HeaderNumber{"mass_kg", &DriveController::mass_kg},
    HeaderNumber{"observer_rad_per_s", &DriveController::observer_rad_per_s},
    HeaderNumber{"position_gain_per_s", &DriveController::position_gain_per_s},
    HeaderNumber{"velocity_gain_N_s_per_m", &DriveController::velocity_gain_N_s_per_m},
    HeaderNumber{"integral_per_s", &DriveController::integral_per_s},
    HeaderNumber{"disturbance_share", &DriveController::disturbance_share},
};

class Reader {
 public:
  explicit Reader(const std::string& path) : path_(path), file_(path) {
    if (!file_) throw InputError(fmt::format("{}: cannot be read", printable(path)));
  }

  LoopRecording read() {
    while (std::getline(file_, text_)) {
      ++line_;
      if (!text_.empty() && text_.back() == '\r') text_.pop_back();
      if (text_.empty()) continue;
      if (text_[0] == '#') {
        header_line();
      } else if (!columns_) {
        if (text_ != kColumns) fail(fmt::format("the columns must be {}", kColumns));
        columns_ = true;
        begin();
      } else {
        row();
      }
    }
    if (!columns_) fail("is no recording of `slipstack bode --out`: it has no columns");
    for (const auto& band : made_.bands) {
      if (band.empty()) fail("a band has no samples");
      for (const ExcitedRecord& record : band) check(record, path_);
    }
    return made_;
  }

 private:
  [[noreturn]] void fail(const std::string& why) const {
    throw InputError(fmt::format("{}:{}: {}", printable(path_), line_, why));
  }

  double number(std::string_view field) const {
    double value = 0.0;
    const std::string fault = number_fault(field);
    if (!fault.empty()) fail(fmt::format("{} {}", in_quotes(field), fault));
    parse_double(field.data(), field.data() + field.size(), value);
    return value;
  }

  void header_line() {
    const std::size_t colon = text_.find(':');
    if (colon == std::string::npos) return;
    const std::string key(trimmed(std::string_view(text_).substr(1, colon - 1)));
    header_[key] = std::string(trimmed(std::string_view(text_).substr(colon + 1)));
  }

  double wanted(const std::string& key) const {
    const auto found = header_.find(key);
    if (found == header_.end()) fail(fmt::format("the head has no '# {}:'", key));
    return number(found->second);
  }

  void begin() {
    for (const HeaderNumber& one : kNumbers) made_.drive.*one.member = wanted(one.key);
    if (!(made_.drive.tick_s > 0.0) || !(made_.drive.mass_kg > 0.0))
      fail("tick_s and mass_kg must be positive");
    if (!(made_.drive.velocity_gain_N_s_per_m > 0.0)) fail("the drive has no velocity gain");
    for (std::size_t i = 0; i < made_.drive.notch.size(); ++i) {
      const auto fields = split_fields(header_[fmt::format("notch_{}", i + 1)]);
      if (fields.size() != 3) fail(fmt::format("the head has no '# notch_{}: Hz, damping, depth'", i + 1));
      made_.drive.notch[i] = {number(fields[0]), number(fields[1]), number(fields[2])};
    }
    made_.velocity_mps = wanted("velocity_mps");
    made_.force_limit_N = wanted("force_limit_N");
    made_.motor_constant_N_per_A = wanted("motor_constant_N_per_A");
    for (int band = 1; header_.count(fmt::format("band_{}", band)) != 0; ++band) {
      const auto fields = split_fields(header_[fmt::format("band_{}", band)]);
      if (fields.size() != 5)
        fail(fmt::format("band_{} wants decimation, period, lowest, highest, place", band));
      ExcitedRecord record;
      record.tick_s = made_.drive.tick_s;
      record.decimation = whole(fields[0]);
      record.period_samples = whole(fields[1]);
      record.lowest = whole(fields[2]);
      record.highest = whole(fields[3]);
      record.at_force = fields[4] == "force";
      shapes_.push_back(record);
    }
    if (shapes_.empty()) fail("the head has no '# band_1:'");
    made_.bands.resize(shapes_.size());
  }

  std::size_t whole(std::string_view field) const {
    const double value = number(field);
    if (!(value >= 0.0 && value <= 1e7) || value != std::floor(value))
      fail(fmt::format("{} is no count", in_quotes(field)));
    return static_cast<std::size_t>(value);
  }

  void row() {
    const auto fields = split_fields(text_);
    if (fields.size() != 5) fail(fmt::format("{} fields instead of 5", fields.size()));
    const std::size_t band = whole(fields[0]);
    const std::size_t capture = whole(fields[1]);
    if (band < 1 || band > shapes_.size()) fail(fmt::format("there is no band {}", band));
    auto& captures = made_.bands[band - 1];
    if (capture < 1 || capture > captures.size() + 1)
      fail(fmt::format("capture {} is out of order", capture));
    if (capture == captures.size() + 1) captures.push_back(shapes_[band - 1]);
    ExcitedRecord& record = captures[capture - 1];
    record.position_m.push_back(number(fields[2]));
    record.force_N.push_back(number(fields[3]));
    record.excitation.push_back(number(fields[4]));
  }

  std::string path_;
  std::ifstream file_;
  std::string text_;
  std::size_t line_ = 0;
  bool columns_ = false;
  std::map<std::string, std::string> header_;
  std::vector<ExcitedRecord> shapes_;
  LoopRecording made_;
};

}  // namespace

LoopRecording read_recording(const std::string& path) {
  return Reader(path).read();
}

std::string recording_text(const LoopRecording& recording) {
  std::string text;
  for (const HeaderNumber& one : kNumbers)
    text += fmt::format("# {}: {}\n", one.key, recording.drive.*one.member);
  for (std::size_t i = 0; i < recording.drive.notch.size(); ++i) {
    const DriveNotch& notch = recording.drive.notch[i];
    text += fmt::format("# notch_{}: {}, {}, {}\n", i + 1, notch.frequency_Hz, notch.damping, notch.depth);
  }
  text += fmt::format("# velocity_mps: {}\n# force_limit_N: {}\n# motor_constant_N_per_A: {}\n",
                      recording.velocity_mps, recording.force_limit_N, recording.motor_constant_N_per_A);
  for (std::size_t band = 0; band < recording.bands.size(); ++band) {
    const ExcitedRecord& one = recording.bands[band].front();
    text += fmt::format("# band_{}: {}, {}, {}, {}, {}\n", band + 1, one.decimation, one.period_samples,
                        one.lowest, one.highest, one.at_force ? "force" : "position");
  }
  text += fmt::format("{}\n", kColumns);
  for (std::size_t band = 0; band < recording.bands.size(); ++band) {
    for (std::size_t capture = 0; capture < recording.bands[band].size(); ++capture) {
      const ExcitedRecord& one = recording.bands[band][capture];
      for (std::size_t i = 0; i < one.position_m.size(); ++i) {
        text += fmt::format("{},{},{:.12g},{:.9g},{:.9g}\n", band + 1, capture + 1, one.position_m[i],
                            one.force_N[i], one.excitation[i]);
      }
    }
  }
  return text;
}

}  // namespace slipstack::workbench
