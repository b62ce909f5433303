// SPDX-License-Identifier: Apache-2.0
#include "workbench/c_export/recording.h"

#include <fmt/format.h>

#include <cmath>
#include <functional>
#include <utility>

namespace slipstack::workbench {
namespace {

thread_local ComputationRecord* current_recording = nullptr;

template <class T>
std::string literal(T value, const char* suffix) {
  if (!std::isfinite(value)) throw NotRecordable("a parameter or what is made of it is not a finite number");
  std::string text = fmt::format("{}", value);  // the shortest that reads back as the same number
  if (text.find_first_of(".e") == std::string::npos) text += ".0";
  text += suffix;
  return std::signbit(value) ? "(" + text + ")" : text;
}

}  // namespace

ValueId ComputationRecord::leaf(std::string text) {
  return operation(std::move(text), {}, "REAL", false);
}

ValueId ComputationRecord::operation(std::string form, std::vector<ValueId> operands, std::string type,
                                     bool compound) {
  const auto [known, is_new] = known_.try_emplace({form, operands}, values_.size());
  if (is_new) values_.push_back({std::move(form), std::move(operands), std::move(type), compound});
  return known->second;
}

std::string ComputationRecord::table(std::string type, std::string extents, std::string rows) {
  for (const Table& table : tables_) {
    if (table.rows == rows && table.type == type) return table.name;
  }
  std::string name = fmt::format("@table_{}", tables_.size());
  tables_.push_back({std::move(type), name, std::move(extents), std::move(rows)});
  return name;
}

void ComputationRecord::add_used(ValueId id, std::set<ValueId>& used) const {
  std::vector<ValueId> open{id};
  while (!open.empty()) {
    const ValueId next = open.back();
    open.pop_back();
    if (!used.insert(next).second) continue;
    const std::vector<ValueId>& operands = values_[next].operands;
    open.insert(open.end(), operands.begin(), operands.end());
  }
}

void ComputationRecord::watch(const void* begin, std::size_t size) {
  begin_ = static_cast<const std::byte*>(begin);
  size_ = size;
}

bool ComputationRecord::is_watched(const void* place) const {
  const auto* const byte = static_cast<const std::byte*>(place);
  return std::greater_equal<>{}(byte, begin_) && std::less<>{}(byte, begin_ + size_);
}

void ComputationRecord::constructed(void* scalar) {
  if (is_watched(scalar)) members_.insert(scalar);
}

void ComputationRecord::destroyed(void* scalar) {
  if (is_watched(scalar)) members_.erase(scalar);
}

ComputationRecord* ComputationRecord::current() {
  return current_recording;
}

ComputationRecord::ComputationRecord() : previous_(current_recording) {
  current_recording = this;
}

ComputationRecord::~ComputationRecord() {
  current_recording = previous_;
}

std::string c_literal(float value) {
  return literal(value, "F");
}

std::string c_literal(double value) {
  return literal(value, "");
}

}  // namespace slipstack::workbench
