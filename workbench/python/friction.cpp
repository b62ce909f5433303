// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <cmath>
#include <cstddef>
#include <memory>
#include <mutex>
#include <span>
#include <variant>
#include <vector>

#include "firmware/effects/presliding_hysteresis.h"
#include "firmware/friction/maxwell_slip.h"
#include "firmware/friction/memory_stack.h"
#include "workbench/base/errors.h"
#include "workbench/python/bindings.h"

namespace slipstack::workbench {
namespace {

using Positions = py::array_t<double, py::array::c_style | py::array::forcecast>;
using Forces = py::array_t<double>;

void check(SetupStatus status, std::size_t capacity) {
  switch (status) {
    case SetupStatus::kOk:
      return;
    case SetupStatus::kTooMany:
      throw InputError(fmt::format("more than {} elements or knots; give fewer", capacity));
    case SetupStatus::kSizeMismatch:
      throw InputError("the two arrays differ in length; give one value of each for each element or knot");
    case SetupStatus::kOutOfRange:
      throw InputError("a parameter is negative or not finite; give finite values, none below zero");
    case SetupStatus::kNotAscending:
      throw InputError("the knots do not ascend from above zero; sort them and leave the origin out");
  }
}

std::span<const double> values_of(const Positions& values, const char* what) {
  if (values.ndim() != 1) throw InputError(fmt::format("{}: give an array of one dimension", what));
  return {values.data(), static_cast<std::size_t>(values.size())};
}

std::span<const double> positions_of(const Positions& position) {
  const std::span<const double> x = values_of(position, "position");
  for (std::size_t i = 0; i < x.size(); ++i) {
    if (!std::isfinite(x[i])) throw InputError(fmt::format("position: element {} is {}", i, x[i]));
  }
  return x;
}

/// The force at each position, one step of `model` after the other, without the lock of the interpreter.
template <class Model>
Forces forces_along(Model& model, std::mutex& lock, const Positions& position) {
  const std::span<const double> x = positions_of(position);
  Forces force(static_cast<py::ssize_t>(x.size()));
  double* const out = force.mutable_data();
  {
    const py::gil_scoped_release release;
    const std::lock_guard alone(lock);
    Model moved = model;  // a copy that no pointer leads to: what does not change stays in registers
    for (std::size_t i = 0; i < x.size(); ++i) out[i] = moved.step(x[i]);
    model = moved;
  }
  return force;
}

template <std::size_t N>
using Elements = MaxwellSlip<N, double, double>;

/// With as many places as the controller has, or, for more elements, as the workbench identifies: the work of
/// a step grows with the places, used or not.
class ArrayMaxwellSlip {
 public:
  ArrayMaxwellSlip(const Positions& slip_distance, const Positions& stiffness) {
    const std::span<const double> distances = values_of(slip_distance, "slip_distance");
    const std::span<const double> stiffnesses = values_of(stiffness, "stiffness");
    count_ = distances.size();
    if (count_ > kFew) elements_.emplace<Elements<kMany>>();
    std::visit([&](auto& model) { check(model.set_elements(distances, stiffnesses), kMany); }, elements_);
  }

  void reset(double position) {
    const std::lock_guard alone(lock_);
    std::visit([&](auto& model) { model.reset(position); }, elements_);
  }

  Forces step(const Positions& position) {
    return std::visit([&](auto& model) { return forces_along(model, lock_, position); }, elements_);
  }

  /// Row i: the stretches after position i.
  Forces stretches(const Positions& position) {
    const std::span<const double> x = positions_of(position);
    Forces rows({static_cast<py::ssize_t>(x.size()), static_cast<py::ssize_t>(count_)});
    double* const out = rows.mutable_data();
    const py::gil_scoped_release release;
    const std::lock_guard alone(lock_);
    std::visit(
        [&](auto& model) {
          for (std::size_t i = 0; i < x.size(); ++i) {
            model.step(x[i]);
            model.elements({out + i * count_, count_});
          }
        },
        elements_);
    return rows;
  }

  double stored_energy() {
    const std::lock_guard alone(lock_);
    return std::visit([](auto& model) { return model.stored_energy(); }, elements_);
  }

 private:
  static constexpr auto kFew = static_cast<std::size_t>(kTargetElements);
  static constexpr auto kMany = static_cast<std::size_t>(kIdentifiedElements);
  std::mutex lock_;
  std::size_t count_ = 0;
  std::variant<Elements<kFew>, Elements<kMany>> elements_;
};

constexpr std::size_t kDepth = 16;  // as on the controller (firmware/control/force/hysteresis_memory.h)
constexpr std::size_t kKnots = 32;  // as many as elements are identified

using Rational = RationalCurve<double>;
using Piecewise = PiecewiseLinearCurve<kKnots, double>;

class ArrayMemoryStack {
 public:
  static std::unique_ptr<ArrayMemoryStack> rational(double height_N, double length) {
    const Rational curve{height_N, length};
    if (!curve.valid()) {
      throw InputError("height_N must be finite and not negative, length finite and above zero");
    }
    return std::make_unique<ArrayMemoryStack>(MemoryStack<Rational, kDepth>(curve));
  }

  static std::unique_ptr<ArrayMemoryStack> piecewise(const Positions& knots, const Positions& force_N) {
    Piecewise curve;
    check(curve.set_knots(values_of(knots, "knots"), values_of(force_N, "force_N")), kKnots);
    return std::make_unique<ArrayMemoryStack>(MemoryStack<Piecewise, kDepth>(curve));
  }

  template <class Curve>
  explicit ArrayMemoryStack(const MemoryStack<Curve, kDepth>& stack) : stack_(stack) {}

  void reset(double position) {
    const std::lock_guard alone(lock_);
    std::visit([&](auto& model) { model.reset(position); }, stack_);
  }

  Forces step(const Positions& position) {
    return std::visit([&](auto& model) { return forces_along(model, lock_, position); }, stack_);
  }

  std::size_t depth() {
    const std::lock_guard alone(lock_);
    return std::visit([](auto& model) { return model.depth(); }, stack_);
  }

  std::size_t overflow_count() {
    const std::lock_guard alone(lock_);
    return std::visit([](auto& model) -> std::size_t { return model.overflow_count(); }, stack_);
  }

  double overflow_height_N() {
    const std::lock_guard alone(lock_);
    return std::visit([](auto& model) { return model.overflow_height_N(); }, stack_);
  }

 private:
  std::mutex lock_;
  std::variant<MemoryStack<Rational, kDepth>, MemoryStack<Piecewise, kDepth>> stack_;
};

}  // namespace

void define_friction(py::module_& m) {
  py::class_<ArrayMaxwellSlip>(m, "MaxwellSlip", R"(Maxwell-slip hysteresis: springs in parallel that slip.

slip_distance: deflections at which the elements slip, >= 0. stiffness: theirs, >= 0, in N per unit of
slip_distance. Any unit of length; up to 32 elements. The C++ of firmware/friction/maxwell_slip.h in double
precision; the state lasts from call to call. Raises InputError.)")
      .def(py::init<const Positions&, const Positions&>(), py::arg("slip_distance"), py::arg("stiffness"))
      .def("reset", &ArrayMaxwellSlip::reset, py::arg("position") = 0.0,
           "Unloads every element at this position.")
      .def(
          "step", &ArrayMaxwellSlip::step, py::arg("position"),
          R"(The friction force (n,) in N at positions (n,), one after the other: against the motion, positive
after motion towards +x. Up to ten elements take a path of their own, which is faster.)")
      .def("stretches", &ArrayMaxwellSlip::stretches, py::arg("position"),
           R"(Moves along positions (n,) and gives the stretch of each element after each, (n, elements): the
regressors of the stiffnesses.)")
      .def_property_readonly("stored_energy", &ArrayMaxwellSlip::stored_energy,
                             "Energy of the springs, in N times the unit of length.");
  py::class_<ArrayMemoryStack>(m, "MemoryStack", R"(Hysteresis by a virgin curve and a stack of reversals.

Made by MemoryStack.rational or MemoryStack.piecewise. The C++ of firmware/friction/memory_stack.h in double
precision, 16 reversals deep as on the controller; the state lasts from call to call.)")
      .def_static("rational", &ArrayMemoryStack::rational, py::arg("height_N"), py::arg("length"),
                  R"(With the virgin curve height_N (1 - (length / (x + length))^2); length in the unit of the
positions. Raises InputError.)")
      .def_static("piecewise", &ArrayMemoryStack::piecewise, py::arg("knots"), py::arg("force_N"),
                  R"(With straight lines from the origin through up to 32 knots, level after the last; knots
ascending, in the unit of the positions. Raises InputError.)")
      .def("reset", &ArrayMemoryStack::reset, py::arg("position") = 0.0,
           "Forgets everything: the virgin state at this position.")
      .def(
          "step", &ArrayMemoryStack::step, py::arg("position"),
          R"(The friction force (n,) in N at positions (n,), one after the other: against the motion, positive
after motion towards +x.)")
      .def_property_readonly("depth", &ArrayMemoryStack::depth, "Reversals held; 0 on the virgin curve.")
      .def_property_readonly("overflow_count", &ArrayMemoryStack::overflow_count,
                             "Loops that gave way to a full stack since construction.")
      .def_property_readonly("overflow_height_N", &ArrayMemoryStack::overflow_height_N,
                             "Height of the highest of them: a bound of the error.");
}

}  // namespace slipstack::workbench
