// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

namespace slipstack::workbench {

namespace py = pybind11;

/// The classes of the friction core, vectorised: one call for an array of positions.
void define_friction(py::module_& m);

}  // namespace slipstack::workbench
