// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <map>
#include <set>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace slipstack::workbench {

/// An effect computes something that a recording cannot follow; what() says what, without a place.
struct NotRecordable : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// A value of a recording: an index into ComputationRecord::values().
using ValueId = std::size_t;

/// What a computation did, as values that depend on earlier ones: the same operation on the same operands is
/// one value. `@` in a text stands for the prefix of all names of a header, `REAL` for its scalar.
class ComputationRecord {
 public:
  struct Value {
    std::string form;  ///< C text; {} for each operand
    std::vector<ValueId> operands;
    std::string type;       ///< C type
    bool compound = false;  ///< an expression that needs parentheses within another
    bool is_leaf() const { return operands.empty(); }
  };
  struct Table {
    std::string type;
    std::string name;
    std::string extents;  ///< such as [64][3]
    std::string rows;     ///< initialiser
  };
  /// Stop operators: C literals, one for each element that is used.
  struct Hysteresis {
    std::vector<std::string> slip_distance;
    std::vector<std::string> stiffness;
    std::string scale;  ///< factor of the sum; empty: one
  };

  /// A literal or the name of something that is given.
  ValueId leaf(std::string text);
  /// An operation on earlier values.
  ValueId operation(std::string form, std::vector<ValueId> operands, std::string type = "REAL",
                    bool compound = true);
  /// The name of a table of constants; equal tables are one.
  std::string table(std::string type, std::string extents, std::string rows);

  const std::vector<Value>& values() const { return values_; }
  const std::vector<Table>& tables() const { return tables_; }
  /// Adds all values that `id` depends on, and itself.
  void add_used(ValueId id, std::set<ValueId>& used) const;

  Hysteresis hysteresis;

  /// Scalars that are constructed within [begin, begin + size) from now on are members of what is recorded.
  void watch(const void* begin, std::size_t size);
  void constructed(void* scalar);
  void destroyed(void* scalar);
  const std::set<void*>& members() const { return members_; }

  /// The newest recording of this thread that was not destroyed yet; nullptr without one.
  static ComputationRecord* current();
  ComputationRecord();
  ~ComputationRecord();
  ComputationRecord(const ComputationRecord&) = delete;
  ComputationRecord& operator=(const ComputationRecord&) = delete;

 private:
  bool is_watched(const void* place) const;

  std::vector<Value> values_;
  std::map<std::pair<std::string, std::vector<ValueId>>, ValueId> known_;
  std::vector<Table> tables_;
  std::set<void*> members_;
  const std::byte* begin_ = nullptr;
  std::size_t size_ = 0;
  ComputationRecord* previous_;
};

/// A C literal that reads back as the same number: 0.1F, 2.0; negative ones in parentheses.
std::string c_literal(float value);
std::string c_literal(double value);

}  // namespace slipstack::workbench
