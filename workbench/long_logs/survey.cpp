// SPDX-License-Identifier: Apache-2.0
#include "workbench/long_logs/survey.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "workbench/base/axis_units.h"
#include "workbench/log/assemble.h"
#include "workbench/log/csv/columns.h"
#include "workbench/log/csv/csv.h"
#include "workbench/log/mat/mat.h"
#include "workbench/log/sampling/sampling.h"

namespace slipstack::workbench {
namespace {

/// The sampling rates of two chunks of a log differ by less than this, or samples are missing; chosen.
constexpr double kSameRate = 1e-3;

struct Extremes {
  double low = std::numeric_limits<double>::infinity();
  double high = -std::numeric_limits<double>::infinity();
  void take(const std::vector<double>& values) {
    for (const double value : values) {
      low = std::min(low, value);
      high = std::max(high, value);
    }
  }
};

std::string name_of(const RawTable& table, const ColumnPlan& plan, Quantity quantity) {
  return table.source + ": column " + table.columns[plan[quantity]->column].name;
}

/// Reads a file chunk by chunk and collects the survey.
class Surveyor {
 public:
  Surveyor(const std::string& name, const InputFile& file) : source_(file, 0), reader_(name, source_) {
    found_.bytes = file.size();
  }

  Survey run() {
    for (;;) {
      const LineReader::Place place = reader_.place();
      RawTable rows = reader_.rows(kRowsPerPlace);
      if (rows.columns.front().values.empty()) break;
      take(place, std::move(rows));
    }
    finish();
    return std::move(found_);
  }

 private:
  void take(const LineReader::Place& place, RawTable rows) {
    const std::size_t count = rows.columns.front().values.size();
    const bool first = found_.samples == 0;
    const std::string where = rows.where_row(0);
    if (first) found_.table = CsvReader::without_rows(rows);
    // The last chunk may be too short for an estimate of its rate.
    const bool long_enough = count >= Log::kMinimumSamples;
    const Log chunk = assemble_chunk(std::move(rows), long_enough ? nullptr : &found_.head);
    if (first) {
      found_.head = chunk;
      for (const auto column : kSampleColumns) std::vector<double>().swap(found_.head.*column);
    } else {
      require_continuation(where, chunk);
    }
    if (chunk.encoder_resolution_m) {
      found_.head.encoder_resolution_m =
          std::min(*chunk.encoder_resolution_m,
                   found_.head.encoder_resolution_m.value_or(*chunk.encoder_resolution_m));
    }
    last_s_ = chunk.start_time_s + static_cast<double>(count - 1) / found_.head.sample_rate_Hz;
    position_m_.take(chunk.position_m);
    force_N_.take(chunk.force_N);
    found_.envelope.take(chunk.position_m);
    found_.places.push_back(place);
    found_.samples += count;
  }

  /// Throws InputError unless the chunk continues the samples before it at the same rate.
  void require_continuation(const std::string& where, const Log& chunk) const {
    const double rate_Hz = found_.head.sample_rate_Hz;
    const double step_s = 1.0 / rate_Hz;
    const double gap_s = chunk.start_time_s - last_s_;
    if (gap_s < kShortestStep * step_s || gap_s > kLongestStep * step_s) {
      throw InputError(
          fmt::format("{}: column time_s: a step of {:.6g} s where the others are {:.6g} s; cut the "
                      "log there",
                      where, gap_s, step_s));
    }
    if (std::abs(chunk.sample_rate_Hz - rate_Hz) > kSameRate * rate_Hz) {
      throw InputError(
          fmt::format("{}: sampled at {:.6g} Hz from here on, at {:.6g} Hz before; cut the log there", where,
                      chunk.sample_rate_Hz, rate_Hz));
    }
  }

  /// Completes the survey and checks what only the whole log shows.
  void finish() {
    found_.head.notes = reader_.rows(0).notes;
    const bool declared = found_.table.header.contains(axis_key("encoder_resolution_m"));
    if (!declared && found_.head.encoder_resolution_m) {
      found_.head.notes.push_back(estimated_resolution_note(*found_.head.encoder_resolution_m));
    }
    const ColumnPlan plan = plan_columns(found_.table, read_header_values(found_.table));
    const Quantity force = plan[Quantity::kForce] ? Quantity::kForce : Quantity::kCurrent;
    require_motion(name_of(found_.table, plan, Quantity::kPosition), position_m_.low, position_m_.high,
                   found_.head.encoder_resolution_m);
    require_force(name_of(found_.table, plan, force), force_N_.low, force_N_.high);
    found_.travel_m = position_m_.high - position_m_.low;
  }

  FileSource source_;
  CsvReader reader_;
  Survey found_;
  Extremes position_m_, force_N_;
  double last_s_ = 0.0;
};

}  // namespace

bool reads_in_chunks(const std::string& name, const InputFile& file) {
  std::array<char, kMatHeaderSize> head{};
  if (looks_like_mat({head.data(), file.read_at(0, head.data(), head.size())})) return false;
  FileSource source(file, 0);
  return !read_header_values(CsvReader(name, source).rows(0)).irregular_sampling;
}

Survey survey(const std::string& name, const InputFile& file) {
  return Surveyor(name, file).run();
}

}  // namespace slipstack::workbench
