// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <malloc.h>
#include <signal.h>

#include <CLI/CLI.hpp>
#include <cstdlib>
#include <memory>

#include "workbench/base/errors.h"
#include "workbench/base/text.h"
#include "workbench/cli/commands.h"
#include "workbench/cli/define_commands.h"
#include "workbench/long_logs/processes/mpi_group.h"
#include "workbench/long_logs/processes/requests.h"
#include "workbench/long_logs/shared_logs.h"
#include "workbench/papers/stop.h"

namespace {

using namespace slipstack::workbench;

void complain(std::string_view message) {
  fmt::print(stderr, "slipstack: {}\n", as_one_line(message));
}

/// The parser alone reports an unknown command as a missing one.
void check_command(const CLI::App& app, int argc, char** argv) {
  if (argc < 2 || argv[1][0] == '-') return;
  std::vector<std::string> known;
  for (const CLI::App* command : app.get_subcommands([](const CLI::App*) { return true; })) {
    if (command->get_name() == argv[1]) return;
    known.push_back(command->get_name());
  }
  throw UsageError(fmt::format("unknown command {}; known: {}", in_quotes(argv[1]), joined(known)));
}

/// The command as it can be typed in a shell: words with blanks or special characters are quoted.
std::string command_line(int argc, char** argv) {
  constexpr std::string_view kPlain =
      "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-+=.,:/@%";
  std::string line = "slipstack";
  for (int i = 1; i < argc; ++i) {
    const std::string_view word = argv[i];
    const bool plain = !word.empty() && word.find_first_not_of(kPlain) == std::string_view::npos;
    line += ' ';
    if (plain) {
      line += word;
      continue;
    }
    line += '\'';
    for (const char c : word) line += c == '\'' ? "'\\''" : std::string(1, c);
    line += '\'';
  }
  return line;
}

/// Runs the command line; returns the exit status.
int run(ProcessGroup& group, int argc, char** argv) {
  Options options;
  options.group = &group;
  CLI::App app("slipstack: friction models of rolling guideways, compared with measurements");
  app.name("slipstack");
  try {
    define_commands(app, options);
    check_command(app, argc, argv);
    options.command_line = command_line(argc, argv);
    app.parse(argc, argv);
    return 0;
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app.exit(error);
    complain(fmt::format("{}; see `slipstack --help`", error.what()));
    return kUnusableInput;
  } catch (const Stopped& stopped) {
    complain(stopped.what());
    return kStoppedStatus;
  } catch (...) {
    const ErrorReport report = error_report_of(std::current_exception());
    fmt::print(stderr, "slipstack: {}\n{}", report.line, report.picture);
    return report.status;
  }
}

/// Of the processes that mpirun started, the first runs the command line; the others serve its requests.
int run_in_group(int argc, char** argv) {
  std::unique_ptr<ProcessGroup> group;
  try {
    group = join_process_group();
  } catch (const InputError& error) {
    if (is_first_started()) complain(error.what());
    return kUnusableInput;
  }
  if (group->is_first()) {
    const Dismissal dismissal(*group);
    return run(*group, argc, argv);
  }
  try {
    serve_logs(*group);
    return 0;
  } catch (const std::exception& error) {
    complain(fmt::format("process {}: internal fault: {}", group->rank(), error.what()));
    std::_Exit(kInternalFault);  // mpirun then ends the others, which wait for this one
  }
}

/// Keeps freed memory in the process. Signals of a long log are allocated and freed hundreds of times; by
/// default the C library returns blocks of their size to the kernel and gets them page by page again, which
/// took a third of the processor time of a diagnosis of 5e5 samples (tests/bench/speed/cost_by_length.py).
void keep_freed_memory() {
  constexpr int kLargest = 1 << 25;  // more is refused
  constexpr int kAhead = 1 << 26;
  ::mallopt(M_ARENA_MAX, 1);  // the arenas of threads give memory back
  ::mallopt(M_MMAP_THRESHOLD, kLargest);
  ::mallopt(M_TRIM_THRESHOLD, 1 << 30);
  ::mallopt(M_TOP_PAD, kAhead);
}

}  // namespace

int main(int argc, char** argv) {
  keep_freed_memory();
  // A file that exceeds the size limit is reported as an error; the signal would end the program.
  ::signal(SIGXFSZ, SIG_IGN);
  return run_in_group(argc, argv);
}
