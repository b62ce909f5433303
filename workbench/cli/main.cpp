// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <CLI/CLI.hpp>

#include "workbench/cli/commands.h"
#include "workbench/cli/output.h"
#include "workbench/log/input_error.h"

namespace {

using namespace slipstack::workbench;

constexpr int kUnusableInput = 2;
constexpr int kInternalFault = 1;

/// One line, whatever a message was made of.
void complain(std::string_view message) {
  std::string line(message.substr(0, message.find_last_not_of('\n') + 1));
  for (char& c : line) {
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7F) c = ' ';
  }
  fmt::print(stderr, "slipstack: {}\n", line);
}

void add_outputs(CLI::App& command, Options& options) {
  command.add_option("--report", options.report, "write a report, one HTML page that opens offline");
  command.add_option("--json", options.json, "write the result for machines");
}

void define_commands(CLI::App& app, Options& options) {
  app.require_subcommand(1);
  app.set_version_flag("--version", "slipstack " SLIPSTACK_VERSION);

  CLI::App* compare = app.add_subcommand("compare", "Compare a model with a measurement");
  compare->add_option("LOG", options.log, "measurement, CSV or MAT v5")->required();
  compare->add_option("--model", options.model, "model file")->required();
  add_outputs(*compare, options);
  compare->callback([&options] { run_compare(options); });

  CLI::App* fit = app.add_subcommand("fit", "Fit a model of chosen effects to a measurement");
  fit->add_option("LOG", options.log, "measurement, CSV or MAT v5")->required();
  fit->add_option("--effects", options.effects, "effects, separated by commas")->required();
  fit->add_option("--model", options.model, "model file to write")->required();
  add_outputs(*fit, options);
  fit->callback([&options] { run_fit(options); });

  CLI::App* diagnose = app.add_subcommand("diagnose", "Name the physical effect that a model lacks");
  diagnose->add_option("LOG", options.log, "measurement, CSV or MAT v5")->required();
  CLI::Option* effects =
      diagnose->add_option("--effects", options.effects, "baseline (default: inertia,presliding_hysteresis)");
  diagnose->add_option("--model", options.model, "baseline: the effects of this model")->excludes(effects);
  diagnose->add_flag("--stepwise", options.stepwise, "go on until nothing is missing or nothing helps");
  add_outputs(*diagnose, options);
  diagnose->callback([&options] { run_diagnose(options); });

  CLI::App* add = app.add_subcommand("add", "Add an effect to a model and fit it again");
  add->add_option("LOG", options.log, "measurement, CSV or MAT v5")->required();
  add->add_option("--model", options.model, "model file to start from")->required();
  add->add_option("--effect", options.effect, "effect to add")->required();
  add->add_option("--out", options.out, "model file to write")->required();
  add_outputs(*add, options);
  add->callback([&options] { run_add(options); });
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  CLI::App app("slipstack: friction models of rolling guideways, compared with measurements");
  app.name("slipstack");
  try {
    define_commands(app, options);
    app.parse(argc, argv);
    return 0;
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app.exit(error);
    complain(fmt::format("{}; see `slipstack --help`", error.what()));
    return kUnusableInput;
  } catch (const UsageError& error) {
    complain(error.what());
    return kUnusableInput;
  } catch (const InputError& error) {
    complain(error.what());
    return kUnusableInput;
  } catch (const std::bad_alloc&) {
    complain("out of memory; give a shorter log or a larger machine");
    return kInternalFault;
  } catch (const std::exception& error) {
    complain(fmt::format("internal fault: {}", error.what()));
    return kInternalFault;
  }
}
