// SPDX-License-Identifier: Apache-2.0
#include "workbench/papers/define_papers.h"

#include <CLI/CLI.hpp>
#include <memory>

#include "workbench/papers/experiments.h"

namespace slipstack::workbench {
namespace {

void add_setup(CLI::App& command, SetupChoice& choice, const std::string& otherwise) {
  choice.name = otherwise;
  add_word(command, "--setup", choice.name, "NAME|FILE",
           "set-up: one that ships with slipstack, or a TOML file")
      ->capture_default_str();
}

void add_threads(CLI::App& command, std::size_t& threads) {
  command.add_option("--threads", threads, "processors to use (default: all); the result does not change")
      ->check(CLI::Range(1, 1024));
}

/// --setup, --forces-N, --from-Hz, --to-Hz, --points; accuracy, --threads, --resume; the outputs.
void add_sine_options(CLI::App& command, SineOptions& wanted, const std::string& setup) {
  add_setup(command, wanted.setup, setup);
  command
      .add_option("--forces-N", wanted.forces_N,
                  "force amplitudes, separated by commas (default: the set-up's)")
      ->delimiter(',')
      ->type_name("N,N,..");
  command.add_option("--from-Hz", wanted.from_Hz, "lowest frequency (default: the set-up's)")
      ->type_name("HZ");
  command.add_option("--to-Hz", wanted.to_Hz, "highest frequency (default: the set-up's)")->type_name("HZ");
  command
      .add_option("--points", wanted.points, "frequencies, evenly in the logarithm (default: the set-up's)")
      ->check(CLI::Range(2, 10000));
  command
      .add_option("--tolerance", wanted.tolerance, "local error of the integration over the motion's size")
      ->check(CLI::Range(1e-12, 1e-3))
      ->capture_default_str();
  command.add_option("--settled", wanted.settled, "change of the fundamental that may be left to come")
      ->check(CLI::Range(1e-8, 0.1))
      ->capture_default_str();
  command
      .add_option("--most-periods", wanted.most_periods, "patience at one frequency (default: the set-up's)")
      ->check(CLI::Range(4, 1000000));
  add_threads(command, wanted.threads);
  add_word(command, "--resume", wanted.resume, "FILE",
           "where a sweep stopped by Ctrl-C is kept and taken up again");
  add_experiment_outputs(command, wanted.outputs);
}

void add_contact(CLI::App& command, const std::string& prefix, GivenContact& contact,
                 const std::string& whose) {
  const auto number = [&](const std::string& name, double& value, const std::string& kind,
                          const std::string& what) {
    command.add_option("--" + prefix + name, value, what + whose)->type_name(kind);
  };
  number("load-N", contact.load_N, "N", "load per ball");
  number("groove-angle-deg", contact.angle_deg, "DEG", "angle of the V-groove");
  number("ball-diameter-m", contact.diameter_m, "M", "ball diameter");
  number("balls", contact.balls, "COUNT", "number of balls");
  add_word(command, "--" + prefix + "material", contact.material, "NAME",
           "steel, silicon_nitride or diamond_coated" + whose);
}

void define_loops(CLI::App& experiment, const std::string& command_line) {
  CLI::App* command =
      experiment.add_subcommand("loops", "Quasi-static hysteresis loops of stepped amplitude");
  auto wanted = std::make_shared<LoopsOptions>();
  add_setup(*command, wanted->setup, "pick_and_place");
  CLI::Option* amplitudes = command
                                ->add_option("--amplitudes-m", wanted->amplitudes_m,
                                             "displacement amplitudes (default: the set-up's)")
                                ->delimiter(',')
                                ->type_name("M,M,..");
  command
      ->add_option("--forces-N", wanted->forces_N,
                   "force amplitudes: the axis is pushed by a force sine instead")
      ->delimiter(',')
      ->type_name("N,N,..")
      ->excludes(amplitudes);
  command->add_option("--positions-m", wanted->positions_m, "where on the stroke (default: the set-up's)")
      ->delimiter(',')
      ->type_name("M,M,..");
  command->add_option("--frequency-Hz", wanted->frequency_Hz, "of the sine (default: the set-up's)")
      ->type_name("HZ");
  command->add_option("--cycles", wanted->cycles, "cycles to average")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  command->add_flag("--sensors", wanted->sensors, "measure through the set-up's sensors");
  command->add_option("--seed", wanted->seed, "of the sensors' noise")->capture_default_str();
  add_threads(*command, wanted->threads);
  add_experiment_outputs(*command, wanted->outputs);
  command->callback([&command_line, wanted] { run_loops(command_line, *wanted); });
}

void define_step(CLI::App& experiment, const std::string& command_line) {
  CLI::App* command = experiment.add_subcommand("step", "A force step; the natural frequency from the ring");
  auto wanted = std::make_shared<StepOptions>();
  add_setup(*command, wanted->setup, "slideway");
  command->add_option("--force-N", wanted->force_N, "height of the step (default: the set-up's)")
      ->type_name("N");
  command->add_option("--seconds", wanted->seconds, "how long to watch")
      ->check(CLI::Range(1e-6, 1e6))
      ->capture_default_str();
  add_experiment_outputs(*command, wanted->outputs);
  command->callback([&command_line, wanted] { run_step(command_line, *wanted); });
}

void define_free(CLI::App& experiment, const std::string& command_line) {
  CLI::App* command =
      experiment.add_subcommand("free", "Let the axis go from a displacement and watch it ring out");
  auto wanted = std::make_shared<FreeOptions>();
  add_setup(*command, wanted->setup, "theory");
  command->add_option("--release-m", wanted->release_m, "displacement at the start (default: the set-up's)")
      ->type_name("M");
  command->add_option("--turns", wanted->turning_points, "turning points to follow")
      ->check(CLI::Range(2, 1000))
      ->capture_default_str();
  add_experiment_outputs(*command, wanted->outputs);
  command->callback([&command_line, wanted] { run_free(command_line, *wanted); });
}

void define_characterize(CLI::App& experiment, const std::string& command_line) {
  CLI::App* command = experiment.add_subcommand(
      "characterize",
      "Stiffness, damping and damping ratio of hysteresis loops, measured or simulated ([2])");
  auto wanted = std::make_shared<CharacterizeOptions>();
  CLI::Option* log =
      add_word(*command, "LOG", wanted->log, "FILE", "measured loops; without it they are simulated");
  add_setup(*command, wanted->setup, "roller");
  command->get_option("--setup")->excludes(log);
  command->add_option("--preloads", wanted->preloads, "preloads, as multiples of the set-up's")
      ->delimiter(',')
      ->capture_default_str()
      ->excludes(log);
  command
      ->add_flag("--typical", wanted->typical, "with the virgin curve of the damping ratios typical in [2]")
      ->excludes(log);
  add_experiment_outputs(*command, wanted->outputs);
  command->callback([&command_line, wanted] { run_characterize(command_line, *wanted); });
}

void define_guideway(CLI::App& experiment, const std::string& command_line) {
  CLI::App* command =
      experiment.add_subcommand("guideway", "From one measured loop to the loop of another guideway ([2])");
  auto wanted = std::make_shared<GuidewayOptions>();
  add_word(*command, "LOG", wanted->log, "FILE", "measured loops; the largest is taken")->required();
  add_contact(*command, "", wanted->from, ", measured (default: the log's header)");
  add_contact(*command, "to-", wanted->to, ", asked for (default: as measured)");
  command->add_option("--force-ratio", wanted->force_ratio, "force level of the new material over the old")
      ->capture_default_str();
  add_experiment_outputs(*command, wanted->outputs);
  command->callback([&command_line, wanted] { run_guideway(command_line, *wanted); });
}

void define_transducer(CLI::App& experiment, const std::string& command_line) {
  CLI::App* command = experiment.add_subcommand(
      "transducer", "Calibrate a force transducer and correct its hysteresis ([3])");
  auto wanted = std::make_shared<TransducerOptions>();
  CLI::Option* log = add_word(*command, "LOG", wanted->calibration, "FILE",
                              "calibration in load steps; without it one is simulated");
  add_word(*command, "READINGS", wanted->readings, "FILE",
           "another record to correct (default: the calibration)");
  add_setup(*command, wanted->setup, "transducer");
  command->get_option("--setup")->excludes(log);
  command->add_option("--seed", wanted->seed, "of the simulated noise")->capture_default_str()->excludes(log);
  add_word(*command, "--write-log", wanted->write_log, "FILE", "write a simulated calibration and stop")
      ->excludes(log);
  add_experiment_outputs(*command, wanted->outputs);
  command->callback([&command_line, wanted] {
    if (!wanted->write_log.empty()) {
      write_simulated_calibration(*wanted);
    } else {
      run_transducer(command_line, *wanted);
    }
  });
}

void define_stepped_sine(CLI::App& experiment, const std::string& command_line) {
  CLI::App* command =
      experiment.add_subcommand("stepped-sine", "Frequency responses at given force levels, up and down");
  auto wanted = std::make_shared<SteppedSineOptions>();
  add_sine_options(*command, wanted->sine, "pick_and_place");
  command->add_option("--direction", wanted->direction, "up, down, or both: up and then down")
      ->check(CLI::IsMember({"up", "down", "both"}))
      ->capture_default_str();
  command->add_option("--repeats", wanted->repeats, "sweeps of each direction, one after the other")
      ->check(CLI::Range(1, 100))
      ->capture_default_str();
  command->add_flag("--sensors", wanted->sensors, "measure through the set-up's sensors");
  command->add_option("--seed", wanted->seed, "of the sensors' noise")->capture_default_str();
  command->callback([&command_line, wanted] { run_stepped_sine(command_line, *wanted); });
}

void define_describing_function(CLI::App& experiment, const std::string& command_line) {
  CLI::App* command = experiment.add_subcommand("describing-function",
                                                "The analytic frequency response, beside the simulated one");
  auto wanted = std::make_shared<DescribingOptions>();
  add_sine_options(*command, wanted->sine, "pick_and_place");
  command->add_flag("--alone", wanted->alone, "without the simulated sweep beside it");
  command->callback([&command_line, wanted] { run_describing_function(command_line, *wanted); });
}

void define_sensitivity(CLI::App& experiment, const std::string& command_line) {
  CLI::App* command = experiment.add_subcommand(
      "sensitivity", "Where small changes of the saturation level move the response most");
  auto wanted = std::make_shared<SensitivityOptions>();
  add_sine_options(*command, wanted->sine, "pick_and_place");
  command->add_option("--change", wanted->share, "relative change of the saturation level, each way")
      ->check(CLI::Range(1e-6, 0.5))
      ->capture_default_str();
  command->callback([&command_line, wanted] { run_sensitivity(command_line, *wanted); });
}

void define_models(CLI::App& experiment, const std::string& command_line) {
  CLI::App* command = experiment.add_subcommand(
      "models",
      "Six friction models on the same motion: which return to the main loop, and their errors ([3])");
  auto wanted = std::make_shared<ModelsOptions>();
  CLI::Option* log =
      add_word(*command, "LOG", wanted->log, "FILE", "a measurement to fit; without it, simulated");
  add_setup(*command, wanted->setup, "roller");
  command->get_option("--setup")->excludes(log);
  add_experiment_outputs(*command, wanted->outputs);
  command->callback([&command_line, wanted] { run_models(command_line, *wanted); });
}

}  // namespace

CLI::Option* add_word(CLI::App& command, const std::string& name, std::string& value, const std::string& kind,
                      const std::string& description) {
  const auto not_empty = [](const std::string& text) {
    return text.empty() ? std::string("must not be empty") : std::string();
  };
  return command.add_option(name, value, description)->check(not_empty)->type_name(kind);
}

void add_experiment_outputs(CLI::App& command, ExperimentOutputs& outputs) {
  add_word(command, "--report", outputs.report, "FILE", "write a report: one HTML page that opens offline");
  add_word(command, "--json", outputs.json, "FILE", "write the result for machines; '-': standard output");
}

void define_experiments_of_papers(CLI::App& experiment, const std::string& command_line) {
  define_loops(experiment, command_line);
  define_step(experiment, command_line);
  define_free(experiment, command_line);
  define_characterize(experiment, command_line);
  define_guideway(experiment, command_line);
  define_transducer(experiment, command_line);
  define_stepped_sine(experiment, command_line);
  define_describing_function(experiment, command_line);
  define_sensitivity(experiment, command_line);
  define_models(experiment, command_line);
}

}  // namespace slipstack::workbench
