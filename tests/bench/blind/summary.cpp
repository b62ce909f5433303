// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/blind/summary.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>

namespace slipstack::bench {
namespace {

using Test = std::function<bool(const Outcome&)>;
using Outcomes = std::vector<const Outcome*>;

Outcomes those(const Outcomes& all, const Test& test) {
  Outcomes some;
  std::copy_if(all.begin(), all.end(), std::back_inserter(some), [&](const Outcome* o) { return test(*o); });
  return some;
}

std::string rate(const Outcomes& all, const Test& test) {
  if (all.empty()) return "-";
  const std::size_t hits = those(all, test).size();
  return fmt::format("{}/{} {:.1f} %", hits, all.size(),
                     100.0 * static_cast<double>(hits) / static_cast<double>(all.size()));
}

std::string row(const std::string& what, const std::string& is, const std::string& goal) {
  return fmt::format("{:<52} {:>18}  {}\n", what, is, goal);
}

bool is_in(const std::vector<std::string>& list, const std::string& id, std::size_t first) {
  return std::find(list.begin(), list.begin() + static_cast<std::ptrdiff_t>(std::min(first, list.size())),
                   id) != list.begin() + static_cast<std::ptrdiff_t>(std::min(first, list.size()));
}

bool named_first(const Outcome& o) {
  return o.verdict == "missing_effect" && is_in(o.hidden, o.ranking.front(), o.hidden.size());
}

bool all_found(const Outcome& o) {
  return o.verdict == "missing_effect" &&
         std::all_of(o.hidden.begin(), o.hidden.end(),
                     [&](const std::string& id) { return is_in(o.added, id, o.added.size()); });
}

bool right_coordinate(const Outcome& o) {
  if (o.verdict != "unexplained") return false;
  switch (o.kind) {
    case Kind::line:
      return o.coordinate == "frequency" || o.coordinate == "time";
    case Kind::bump:
      return o.coordinate == "position";
    case Kind::backlash:
      return o.coordinate == "reversal";
    default:
      return o.coordinate == "time";
  }
}

double quantile(std::vector<double> values, double q) {
  if (values.empty()) return 0.0;
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(q * static_cast<double>(values.size() - 1) + 0.5)];
}

Test kind_is(Kind kind) {
  return [kind](const Outcome& o) { return o.kind == kind; };
}

std::string headline(const Outcomes& all) {
  const Outcomes clean = those(all, kind_is(Kind::clean));
  const Outcomes single = those(all, kind_is(Kind::single));
  const Outcomes visible = those(single, [](const Outcome& o) { return o.visible(); });
  const Outcomes pairs = those(all, kind_is(Kind::pair));
  const Outcomes triples = those(all, kind_is(Kind::triple));
  const Outcomes outside = those(all, [](const Outcome& o) { return outside_catalogue(o.kind); });
  const Outcomes hiding = those(all, [](const Outcome& o) { return o.kind != Kind::clean; });
  const Test in_two = [](const Outcome& o) {
    return o.verdict == "missing_effect" && is_in(o.ranking, o.hidden.front(), 2);
  };
  const Test complete = [](const Outcome& o) { return o.verdict == "complete"; };
  std::string text = fmt::format("{:<52} {:>18}  {}\n", "blind benchmark", "is", "goal");
  text += row("single effect named first, all", rate(single, named_first), "");
  text += row("single effect named first, error raised by 10 %", rate(visible, named_first), ">= 95 %");
  text += row("single effect in the first two, error raised by 10 %", rate(visible, in_two), "");
  text += row("pair: both in the explanation", rate(pairs, all_found), ">= 90 %");
  text += row("triple: all in the explanation", rate(triples, all_found), "");
  text += row("false alarm on a clean log",
              rate(clean, [](const Outcome& o) { return o.verdict == "missing_effect"; }), "none");
  text += row("clean log complete", rate(clean, complete), "");
  text += row("wrongly complete", rate(hiding, complete), "");
  text += row("outside the catalogue: unexplained",
              rate(outside, [](const Outcome& o) { return o.verdict == "unexplained"; }), "");
  text += row("outside the catalogue: with the right coordinate", rate(outside, right_coordinate), ">= 95 %");
  for (const Kind kind : {Kind::line, Kind::bump, Kind::backlash, Kind::burst, Kind::slip}) {
    text += row(fmt::format("  {}", name_of(kind)), rate(those(all, kind_is(kind)), right_coordinate), "");
  }
  return text;
}

std::string errors(const Outcomes& all) {
  std::vector<double> ratios;
  for (const Outcome* o : all) {
    if (!o->hidden.empty() && all_found(*o)) ratios.push_back(o->explained_over_floor);
  }
  return row("error over floor after adding, median", fmt::format("{:.2f}", quantile(ratios, 0.5)),
             "<= 1.1") +
         row("error over floor after adding, 90 %", fmt::format("{:.2f}", quantile(ratios, 0.9)), "<= 1.3");
}

std::string uncertainty(const Outcomes& all) {
  std::vector<Estimate> estimates;
  for (const Outcome* o : all) estimates.insert(estimates.end(), o->estimates.begin(), o->estimates.end());
  return estimates.empty() ? "" : calibration(estimates);
}

std::string by_visibility(const Outcomes& all) {
  constexpr double kEdges[] = {0.0, 1.1, 1.5, 2.5, 5.0, 10.0, 1e9};
  std::string text = fmt::format("\n{:<24} {:>18} {:>18} {:>18}\n", "error over floor before",
                                 "single named first", "pair found", "triple found");
  for (std::size_t i = 0; i + 1 < std::size(kEdges); ++i) {
    const Outcomes bin = those(all, [&](const Outcome& o) {
      return o.baseline_over_floor >= kEdges[i] && o.baseline_over_floor < kEdges[i + 1];
    });
    const std::string range = i + 2 == std::size(kEdges) ? fmt::format("above {}", kEdges[i])
                                                         : fmt::format("{} to {}", kEdges[i], kEdges[i + 1]);
    text += fmt::format(
        "{:<24} {:>18} {:>18} {:>18}\n", range, rate(those(bin, kind_is(Kind::single)), named_first),
        rate(those(bin, kind_is(Kind::pair)), all_found), rate(those(bin, kind_is(Kind::triple)), all_found));
  }
  return text;
}

/// For single hidden effects the effect that was named instead; those named correctly are summed.
std::string confusion(const Outcomes& all) {
  std::map<std::string, std::map<std::string, int>> seen;
  for (const Outcome* o : those(all, kind_is(Kind::single))) {
    ++seen[o->hidden.front()][o->verdict == "missing_effect" ? o->ranking.front() : o->verdict];
  }
  std::string text = fmt::format("\n{:<32} {:>5} {:>6}  {}\n", "hidden alone", "logs", "right", "else");
  for (const auto& [hidden, named] : seen) {
    int logs = 0;
    std::string other;
    for (const auto& [id, count] : named) {
      logs += count;
      if (id != hidden) other += fmt::format("{}{} {}", other.empty() ? "" : ", ", count, id);
    }
    const auto own = named.find(hidden);
    text +=
        fmt::format("{:<32} {:>5} {:>6}  {}\n", hidden, logs, own == named.end() ? 0 : own->second, other);
  }
  return text;
}

}  // namespace

std::string summary(const std::vector<Outcome>& outcomes) {
  Outcomes all;
  for (const Outcome& outcome : outcomes) all.push_back(&outcome);
  return headline(all) + errors(all) + uncertainty(all) + by_visibility(all) + confusion(all);
}

std::vector<std::string> shortfalls(const std::vector<Outcome>& outcomes) {
  Outcomes all;
  all.reserve(outcomes.size());
  for (const Outcome& outcome : outcomes) all.push_back(&outcome);
  std::vector<std::string> found;
  const auto least = [&](const char* what, const Outcomes& of, const Test& test, double share) {
    const auto hits = static_cast<double>(those(of, test).size());
    if (of.empty() || hits < share * static_cast<double>(of.size()))
      found.push_back(fmt::format("{}: {}, at least {:.0f} % wanted", what, rate(of, test), 100.0 * share));
  };
  const Outcomes clean = those(all, kind_is(Kind::clean));
  least(
      "no false alarm", clean, [](const Outcome& o) { return o.verdict != "missing_effect"; }, 1.0);
  least(
      "clean logs complete", clean, [](const Outcome& o) { return o.verdict == "complete"; }, 0.6);
  least("singles named first", those(all, kind_is(Kind::single)), named_first, 0.75);
  least("pairs found", those(all, kind_is(Kind::pair)), all_found, 0.75);
  const Outcomes outside = those(all, [](const Outcome& o) { return outside_catalogue(o.kind); });
  least("outside the catalogue, with the coordinate", outside, right_coordinate, 0.75);
  const auto within = [&](const char* what, const Outcomes& of, double low, double high) {
    std::vector<double> ratios;
    ratios.reserve(of.size());
    for (const Outcome* o : of) ratios.push_back(o->explained_over_floor);
    const double middle = quantile(ratios, 0.5);
    if (middle < low || middle > high)
      found.push_back(
          fmt::format("{}: median error over floor {:.2f}, not {} to {}", what, middle, low, high));
  };
  // Below one, the noise floor is too high and hides effects.
  within("clean", clean, 0.85, 1.15);
  within("explained", those(all, [](const Outcome& o) { return !o.hidden.empty() && all_found(o); }), 0.85,
         1.25);
  return found;
}

std::string line_of(const Outcome& o) {
  return fmt::format("{} {:<8} {:>5} {:<6} {:<50} {:<15} {:<50} {:>6.2f} -> {:.2f} {}",
                     o.right() ? "  " : "x ", name_of(o.kind), o.seed, o.closed_loop ? "closed" : "",
                     fmt::format("{}", fmt::join(o.hidden, ",")), o.verdict,
                     fmt::format("{}", fmt::join(o.added, ",")), o.baseline_over_floor,
                     o.explained_over_floor, o.coordinate);
}

}  // namespace slipstack::bench
