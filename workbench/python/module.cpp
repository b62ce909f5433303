// SPDX-License-Identifier: Apache-2.0
// slipstack._core: what the package slipstack (slipstack/__init__.py) calls. Not for users: its functions
// take what that package has prepared.
#include "workbench/python/bindings.h"

#include <pybind11/functional.h>
#include <pybind11/stl.h>

#include <cstddef>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "workbench/commands/command.h"
#include "workbench/log/log_of_table.h"
#include "workbench/python/background.h"
#include "workbench/simulate/two_criteria.h"

namespace slipstack::workbench {
namespace {

PyObject* input_error = nullptr;  // slipstack.InputError, for the life of the interpreter

/// Raises InputError with the line that the command line would print.
void raise(const ErrorReport& report) {
  py::object raised = py::reinterpret_borrow<py::object>(input_error)(report.line);
  if (!report.picture.empty() && py::hasattr(raised, "add_note")) {  // Python 3.11
    raised.attr("add_note")(report.picture);
  }
  PyErr_SetObject(input_error, raised.ptr());
}

void translate(std::exception_ptr fault) {
  if (!fault) return;
  const ErrorReport report = error_report_of(fault);
  if (report.status != kUnusableInput) std::rethrow_exception(std::move(fault));  // to pybind11's own
  raise(report);
}

/// Text of ours, in which names of files may be no UTF-8: as Python itself treats such names.
py::str text_of(const std::string& text) {
  return py::reinterpret_steal<py::str>(
      PyUnicode_DecodeUTF8(text.data(), static_cast<Py_ssize_t>(text.size()), "surrogateescape"));
}

using Work = std::function<CommandResult(Outputs& outputs, Progress& progress)>;

/// Does the work of a command without the lock of the interpreter, calls `listener` (None: nobody) in this
/// thread with stage and fraction (None where not known), and gives (text, JSON, file). An exception of the
/// listener, and Ctrl-C, end the work; no file is written then.
py::tuple carry_out(const Work& work, const py::object& listener) {
  CommandResult result;
  Background job([&](Progress& progress) {
    Outputs outputs;
    result = work(outputs, progress);
    throw_if_cancelled();
    outputs.commit("");
  });
  std::vector<Background::Stage> stages;
  bool ended = false;
  try {
    while (!ended) {
      {
        const py::gil_scoped_release release;
        ended = job.wait(stages);
      }
      if (PyErr_CheckSignals() != 0) throw py::error_already_set();
      if (listener.is_none()) continue;
      for (const Background::Stage& stage : stages) {
        listener(stage.name, stage.fraction < 0.0 ? py::object(py::none()) : py::float_(stage.fraction));
      }
    }
  } catch (...) {
    {
      const py::gil_scoped_release release;
      job.cancel();
    }
    throw;
  }
  job.rethrow();
  return py::make_tuple(text_of(result.text), text_of(result.json), text_of(result.file));
}

LogsInMemory logs_of(const std::vector<RawTable>& tables) {
  LogsInMemory logs;
  for (const RawTable& table : tables) logs.emplace(table.source, log_of_table(table));
  return logs;
}

using Numbers = py::array_t<double, py::array::c_style | py::array::forcecast>;

/// A column of a table. `relative_precision` of numbers that were stored in fewer digits than a double's.
void add_column(RawTable& table, const std::string& name, const Numbers& values, double relative_precision) {
  table.columns.push_back({name, {values.data(), values.data() + values.size()}, relative_precision});
}

void add_header(RawTable& table, const std::string& key, const std::string& value) {
  table.header.insert_or_assign(key, RawTable::HeaderEntry{value, 0});
}

void define_requests(py::module_& m) {
  py::class_<RawTable>(m, "Table")
      .def(py::init([](std::string name) {
        RawTable table;
        table.source = std::move(name);
        return table;
      }))
      .def("add_column", add_column)
      .def("add_header", add_header);
  py::class_<CommandOptions>(m, "Options")
      .def(py::init<>())
      .def_readwrite("command_line", &CommandOptions::command_line)
      .def_readwrite("logs", &CommandOptions::logs)
      .def_readwrite("per_log", &CommandOptions::per_log)
      .def_readwrite("noise_N", &CommandOptions::noise_N)
      .def_readwrite("model", &CommandOptions::model)
      .def_readwrite("model_content", &CommandOptions::model_content)
      .def_readwrite("effects", &CommandOptions::effects)
      .def_readwrite("effect", &CommandOptions::effect)
      .def_readwrite("user_effects", &CommandOptions::user_effects)
      .def_readwrite("out", &CommandOptions::out)
      .def_readwrite("report", &CommandOptions::report)
      .def_readwrite("json", &CommandOptions::json)
      .def_readwrite("criterion", &CommandOptions::criterion)
      .def_readwrite("horizon_s", &CommandOptions::horizon_s)
      .def_readwrite("stepwise", &CommandOptions::stepwise);
  py::class_<ExperimentOutputs>(m, "ExperimentOutputs")
      .def(py::init<>())
      .def_readwrite("report", &ExperimentOutputs::report)
      .def_readwrite("json", &ExperimentOutputs::json)
      .def_readwrite("out", &ExperimentOutputs::out);
  py::class_<PlanRequest>(m, "PlanRequest")
      .def(py::init<>())
      .def_readwrite("effects", &PlanRequest::effects)
      .def_readwrite("logs", &PlanRequest::logs)
      .def_readwrite("model", &PlanRequest::model)
      .def_readwrite("model_content", &PlanRequest::model_content)
      .def_readwrite("baseline", &PlanRequest::baseline)
      .def_readwrite("limits", &PlanRequest::limits)
      .def_readwrite("user_effects", &PlanRequest::user_effects)
      .def_readwrite("seconds", &PlanRequest::seconds)
      .def_readwrite("rate_Hz", &PlanRequest::rate_Hz);
  py::class_<SimulateRequest>(m, "SimulateRequest")
      .def(py::init<>())
      .def_readwrite("model", &SimulateRequest::model)
      .def_readwrite("model_content", &SimulateRequest::model_content)
      .def_readwrite("log", &SimulateRequest::log)
      .def_readwrite("set_points", &SimulateRequest::set_points)
      .def_readwrite("points", &SimulateRequest::points)
      .def_readwrite("start_s", &SimulateRequest::start_s)
      .def_readwrite("end_s", &SimulateRequest::end_s);
}

using Execute = decltype(execute_compare);

/// A command on logs. `tables`: those logs that are no files, named by their `source`.
void define_log_command(py::module_& m, const char* name, Execute* execute) {
  m.def(name,
        [execute](CommandOptions options, const std::vector<RawTable>& tables, const py::object& listener) {
          return carry_out(
              [&](Outputs& outputs, Progress& progress) {
                SingleProcess alone;
                options.group = &alone;
                options.in_memory = logs_of(tables);
                return execute(options, outputs, progress);
              },
              listener);
        });
}

}  // namespace

PYBIND11_MODULE(_core, m) {
  // As a reference of our own: pybind11 would drop it with the module, and the translator may still be
  // called.
  input_error = PyErr_NewExceptionWithDoc(
      "slipstack.InputError",
      "Unusable input, or wrong use: one line that says where, what is wrong and what to do. The command\n"
      "line prints the same and ends with status 2.",
      PyExc_ValueError, nullptr);
  m.attr("InputError") = py::reinterpret_borrow<py::object>(input_error);
  py::register_exception_translator(translate);
  m.attr("RUN_HORIZON_S") = kRunHorizon_s;
  m.attr("VERSION") = SLIPSTACK_VERSION;
  define_requests(m);
  define_log_command(m, "compare", execute_compare);
  define_log_command(m, "fit", execute_fit);
  define_log_command(m, "diagnose", execute_diagnose);
  define_log_command(m, "add", execute_add);
  m.def("plan", [](PlanRequest request, const ExperimentOutputs& wanted, const std::string& command_line,
                   const std::vector<RawTable>& tables, const py::object& listener) {
    return carry_out(
        [&](Outputs& outputs, Progress& progress) {
          request.in_memory = logs_of(tables);
          return execute_plan(request, wanted, command_line, outputs, progress);
        },
        listener);
  });
  m.def("simulate",
        [](SimulateRequest request, const ExperimentOutputs& wanted, const std::string& command_line,
           const std::vector<RawTable>& tables, const py::object& listener) {
          return carry_out(
              [&](Outputs& outputs, Progress& progress) {
                request.in_memory = logs_of(tables);
                return execute_simulate(request, wanted, command_line, outputs, progress);
              },
              listener);
        });
  define_friction(m);
}

}  // namespace slipstack::workbench
