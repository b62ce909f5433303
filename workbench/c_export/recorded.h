// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cmath>
#include <concepts>
#include <cstdint>
#include <string>
#include <type_traits>

#include "firmware/effects/effect.h"
#include "firmware/effects/numerics/approx.h"
#include "workbench/c_export/recording.h"

// A scalar that records what is computed with it. An effect of the firmware that is instantiated with it
// writes its own C text: the header of the effect stays the only definition (operator overloading, as in
// algorithmic differentiation: Griewank and Walther, Evaluating Derivatives, 2nd edition 2008, chapter 6).
// What depends on constants alone is computed in T, by the functions of the firmware, and is a constant.
namespace slipstack::workbench {

inline ComputationRecord& recording() {
  return *ComputationRecord::current();
}

/// The result of a comparison. Only a comparison of constants can decide which way a program goes.
class RecordedCondition {
 public:
  explicit RecordedCondition(bool known) : known_(known) {}
  static RecordedCondition of(ValueId value) {
    RecordedCondition condition(false);
    condition.is_known_ = false;
    condition.value_ = value;
    return condition;
  }
  bool is_known() const { return is_known_; }
  // As that of numbers is: an effect may keep it in a bool. NOLINTNEXTLINE(google-explicit-constructor)
  operator bool() const {
    if (!is_known_) throw NotRecordable("it chooses by ?: or if (approx::select does the same)");
    return known_;
  }
  ValueId value() const { return is_known_ ? recording().leaf(known_ ? "1" : "0") : value_; }

 private:
  bool known_;
  bool is_known_ = true;
  ValueId value_ = 0;
};

inline RecordedCondition operator&&(const RecordedCondition& a, const RecordedCondition& b) {
  if (a.is_known()) return static_cast<bool>(a) ? b : a;
  return RecordedCondition::of(recording().operation("{} && {}", {a.value(), b.value()}, "int"));
}
inline RecordedCondition operator||(const RecordedCondition& a, const RecordedCondition& b) {
  if (a.is_known()) return static_cast<bool>(a) ? a : b;
  return RecordedCondition::of(recording().operation("{} || {}", {a.value(), b.value()}, "int"));
}

template <std::floating_point T>
class Recorded {
 public:
  Recorded() { track(); }
  template <class Number>
  requires std::is_arithmetic_v<Number>
  explicit Recorded(Number constant) : constant_(static_cast<T>(constant)) { track(); }
  explicit Recorded(const RecordedCondition& condition) {
    track();
    if (condition.is_known()) {
      constant_ = static_cast<bool>(condition) ? T(1) : T(0);
    } else {
      *this = of(recording().operation("(REAL)({})", {condition.value()}, "REAL", false));
    }
  }
  static Recorded of(ValueId value) {
    Recorded recorded;
    recorded.is_constant_ = false;
    recorded.value_ = value;
    return recorded;
  }
  Recorded(const Recorded& other)
      : constant_(other.constant_), is_constant_(other.is_constant_), value_(other.value_) {
    track();
  }
  Recorded& operator=(const Recorded& other) = default;
  ~Recorded() {
    if (ComputationRecord::current() != nullptr) recording().destroyed(this);
  }

  bool is_constant() const { return is_constant_; }
  /// The number; throws NotRecordable unless it is a constant.
  T constant() const {
    if (!is_constant_) throw NotRecordable("a parameter depends on the motion");
    return constant_;
  }
  ValueId value() const { return is_constant_ ? recording().leaf(c_literal(constant_)) : value_; }
  bool is(T number) const { return is_constant_ && constant_ == number; }
  bool same_as(const Recorded& other) const {
    if (is_constant_ != other.is_constant_) return false;
    return is_constant_ ? constant_ == other.constant_ : value_ == other.value_;
  }

  explicit operator std::int32_t() const {
    if (!is_constant_)
      throw NotRecordable("it makes a whole number of a value (interval_at does the same for a table)");
    return static_cast<std::int32_t>(constant_);
  }

  // What leaves a number as it is, or makes it zero, is left out; the sign of a zero may differ.
  friend Recorded operator+(const Recorded& a, const Recorded& b) {
    if (a.is(T(0))) return b;
    if (b.is(T(0))) return a;
    return binary("{} + {}", a, b, [](T x, T y) { return x + y; });
  }
  friend Recorded operator-(const Recorded& a, const Recorded& b) {
    if (b.is(T(0))) return a;
    return binary("{} - {}", a, b, [](T x, T y) { return x - y; });
  }
  friend Recorded operator*(const Recorded& a, const Recorded& b) {
    if (a.is(T(0)) || b.is(T(1))) return a;
    if (b.is(T(0)) || a.is(T(1))) return b;
    return binary("{} * {}", a, b, [](T x, T y) { return x * y; });
  }
  friend Recorded operator/(const Recorded& a, const Recorded& b) {
    if (b.is(T(1))) return a;
    return binary("{} / {}", a, b, [](T x, T y) { return x / y; });
  }
  Recorded operator-() const {
    return is_constant_ ? Recorded(-constant_) : of(recording().operation("-{}", {value_}));
  }
  Recorded& operator+=(const Recorded& other) { return *this = *this + other; }
  Recorded& operator-=(const Recorded& other) { return *this = *this - other; }
  Recorded& operator*=(const Recorded& other) { return *this = *this * other; }
  Recorded& operator/=(const Recorded& other) { return *this = *this / other; }

  friend RecordedCondition operator<(const Recorded& a, const Recorded& b) {
    return compared("{} < {}", a, b, [](T x, T y) { return x < y; });
  }
  friend RecordedCondition operator>(const Recorded& a, const Recorded& b) {
    return compared("{} > {}", a, b, [](T x, T y) { return x > y; });
  }
  friend RecordedCondition operator<=(const Recorded& a, const Recorded& b) {
    return compared("{} <= {}", a, b, [](T x, T y) { return x <= y; });
  }
  friend RecordedCondition operator>=(const Recorded& a, const Recorded& b) {
    return compared("{} >= {}", a, b, [](T x, T y) { return x >= y; });
  }
  friend RecordedCondition operator==(const Recorded& a, const Recorded& b) {
    return compared("{} == {}", a, b, [](T x, T y) { return x == y; });
  }
  friend RecordedCondition operator!=(const Recorded& a, const Recorded& b) {
    return compared("{} != {}", a, b, [](T x, T y) { return x != y; });
  }

 private:
  void track() {
    if (ComputationRecord::current() != nullptr) recording().constructed(this);
  }
  template <class Compute>
  static Recorded binary(const char* form, const Recorded& a, const Recorded& b, Compute compute) {
    if (a.is_constant_ && b.is_constant_) return Recorded(compute(a.constant_, b.constant_));
    return of(recording().operation(form, {a.value(), b.value()}));
  }
  template <class Compute>
  static RecordedCondition compared(const char* form, const Recorded& a, const Recorded& b, Compute compute) {
    if (a.is_constant_ && b.is_constant_) return RecordedCondition(compute(a.constant_, b.constant_));
    return RecordedCondition::of(recording().operation(form, {a.value(), b.value()}, "int"));
  }

  T constant_{};
  bool is_constant_ = true;
  ValueId value_ = 0;
};

/// A call of a function of the header (c_functions.h), or its value where all arguments are constants.
template <class T, class Compute, class... Arguments>
Recorded<T> recorded_call(const char* form, Compute compute, const Recorded<T>& first,
                          const Arguments&... others) {
  if (first.is_constant() && (others.is_constant() && ...)) {
    return Recorded<T>(compute(first.constant(), others.constant()...));
  }
  return Recorded<T>::of(recording().operation(form, {first.value(), others.value()...}, "REAL", false));
}

/// Both members of a pair that a function of the header returns.
template <class T>
std::array<Recorded<T>, 2> members_of(ValueId pair) {
  return {Recorded<T>::of(recording().operation("{}.first", {pair}, "REAL", false)),
          Recorded<T>::of(recording().operation("{}.second", {pair}, "REAL", false))};
}

}  // namespace slipstack::workbench

// The functions of the firmware for such a scalar: constants by the firmware's own, anything else a call.
namespace slipstack::approx {

// A function template cannot be specialised for a family of types, so each precision is named.
// NOLINTBEGIN(bugprone-macro-parentheses)
#define SLIPSTACK_RECORDED_UNARY(T, function)                              \
  template <>                                                              \
  inline workbench::Recorded<T> function(workbench::Recorded<T> x) {       \
    return workbench::recorded_call(                                       \
        "@" #function "({})", [](T a) { return approx::function(a); }, x); \
  }
#define SLIPSTACK_RECORDED_FUNCTIONS(T)                                                                    \
  SLIPSTACK_RECORDED_UNARY(T, absolute)                                                                    \
  SLIPSTACK_RECORDED_UNARY(T, exp2)                                                                        \
  SLIPSTACK_RECORDED_UNARY(T, exp)                                                                         \
  SLIPSTACK_RECORDED_UNARY(T, exp_minus_one)                                                               \
  SLIPSTACK_RECORDED_UNARY(T, log2)                                                                        \
  SLIPSTACK_RECORDED_UNARY(T, square_root)                                                                 \
  template <>                                                                                              \
  inline workbench::Recorded<T> clamp(workbench::Recorded<T> x, workbench::Recorded<T> low,                \
                                      workbench::Recorded<T> high) {                                       \
    return workbench::recorded_call(                                                                       \
        "@clamp({}, {}, {})", [](T a, T b, T c) { return approx::clamp(a, b, c); }, x, low, high);         \
  }                                                                                                        \
  template <>                                                                                              \
  inline workbench::Recorded<T> power(workbench::Recorded<T> base, workbench::Recorded<T> exponent) {      \
    return workbench::recorded_call(                                                                       \
        "@power({}, {})", [](T a, T b) { return approx::power(a, b); }, base, exponent);                   \
  }                                                                                                        \
  template <>                                                                                              \
  inline SinCos<workbench::Recorded<T>> sin_cos_of_cycles(workbench::Recorded<T> cycles) {                 \
    if (cycles.is_constant()) {                                                                            \
      const SinCos<T> both = sin_cos_of_cycles(cycles.constant());                                         \
      return {workbench::Recorded<T>(both.sin), workbench::Recorded<T>(both.cos)};                         \
    }                                                                                                      \
    const auto both = workbench::members_of<T>(                                                            \
        workbench::recording().operation("@sin_cos({})", {cycles.value()}, "@pair", false));               \
    return {both[0], both[1]};                                                                             \
  }                                                                                                        \
  template <>                                                                                              \
  inline workbench::Recorded<T> select(workbench::RecordedCondition condition, workbench::Recorded<T> yes, \
                                       workbench::Recorded<T> no) {                                        \
    if (condition.is_known()) return static_cast<bool>(condition) ? yes : no;                              \
    return workbench::Recorded<T>::of(                                                                     \
        workbench::recording().operation("{} ? {} : {}", {condition.value(), yes.value(), no.value()}));   \
  }
SLIPSTACK_RECORDED_FUNCTIONS(float)
SLIPSTACK_RECORDED_FUNCTIONS(double)
#undef SLIPSTACK_RECORDED_FUNCTIONS
#undef SLIPSTACK_RECORDED_UNARY
// NOLINTEND(bugprone-macro-parentheses)

}  // namespace slipstack::approx
