// SPDX-License-Identifier: Apache-2.0
#include "workbench/loop/comparison/contenders.h"

#include <atomic>
#include <string>
#include <utility>

#include "firmware/effects/catalogue.h"
#include "workbench/base/parallel.h"
#include "workbench/loop/comparison/workshop.h"

namespace slipstack::workbench {
namespace {

using Kind = ContenderName::Kind;

struct Maker {
  ContenderName name;
  std::function<Contender(const Workshop&, const ContenderName&)> make;
};

Maker with_friction(FrictionKind kind, const std::string& title, const std::string& strength) {
  return {{std::string(name(kind)), title, strength},
          [kind](const Workshop& w, const ContenderName& n) { return w.with_friction(kind, n); }};
}

Maker with_elements(const std::string& id, const std::string& title) {
  return {{id, title, "it knows where the axis last turned round", Kind::kOurs},
          [](const Workshop& w, const ContenderName& n) { return w.maxwell_slip(n, {}); }};
}

Maker bound(const std::string& id, const std::string& title, double noise_share, double encoder_share) {
  return {{id, title, "", Kind::kBound},
          [=](const Workshop& w, const ContenderName& n) { return w.bound(n, noise_share, encoder_share); }};
}

std::vector<Maker> few() {
  return {{{"p_pi", "P/PI alone", "it adds nothing that could be wrong"},
           [](const Workshop& w, const ContenderName& n) { return w.without_mass(n); }},
          {{"mass", "with mass", "it adds nothing that friction could make wrong"},
           [](const Workshop& w, const ContenderName& n) { return w.plain(n); }},
          with_friction(FrictionKind::kVelocityTable, "velocity table, 20 points",
                        "far from a reversal, friction is a function of velocity"),
          with_elements("maxwell_slip", "slipstack")};
}

// Beside the few, before slipstack's own.
std::vector<Maker> peers() {
  const std::string form = "its form fits this axis as well as elements do, with fewer parameters";
  const std::string any_force = "it answers to every force, known or not";
  return {with_friction(FrictionKind::kCoulombStribeck, "Coulomb, Stribeck, viscous",
                        "far from a reversal, friction is a function of velocity"),
          with_friction(FrictionKind::kDahl, "Dahl", form),
          with_friction(FrictionKind::kLuGre, "LuGre", form),
          with_friction(FrictionKind::kElastoPlastic, "elasto-plastic", form),
          with_friction(FrictionKind::kGms, "GMS", "its elements are the same in pre-sliding"),
          {{"observer", "disturbance observer alone", any_force},
           [](const Workshop& w, const ContenderName& n) { return w.with_observer(w.without_mass(n)); }},
          {{"observer_mass", "disturbance observer, mass", any_force},
           [](const Workshop& w, const ContenderName& n) { return w.with_observer(w.plain(n)); }},
          {{"ilc", "iterative learning, 10 repetitions", "it has made this very motion nine times before",
            Kind::kLearner},
           [](const Workshop& w, const ContenderName& n) { return w.learning(n); }}};
}

// Behind slipstack as it is.
std::vector<Maker> ours_with_more() {
  Maker maps = with_elements("maxwell_slip_maps", "slipstack, maps");
  maps.make = [](const Workshop& w, const ContenderName& n) {
    return w.maxwell_slip(n, {ForceRipple<float>::text.id, PositionDependentPreload<float>::text.id});
  };
  Maker adapted = with_elements("maxwell_slip_adapted", "slipstack, adaptation");
  adapted.make = [](const Workshop& w, const ContenderName& n) {
    Contender c = w.maxwell_slip(n, {});
    c.axis.adapt_level = c.axis.adapt_mass = true;
    return c;
  };
  Maker observer = with_elements("maxwell_slip_observer", "slipstack, observer");
  observer.make = [](const Workshop& w, const ContenderName& n) {
    return w.with_observer(w.maxwell_slip(n, {}));
  };
  return {maps, adapted, observer};
}

// Of an axis that has effects of which nobody has told.
std::vector<Maker> diagnosed() {
  Maker alone = with_elements("maxwell_slip_diagnosed", "slipstack, diagnosed");
  alone.make = [](const Workshop& w, const ContenderName& n) { return w.diagnosed(n); };
  Maker observer = with_elements("maxwell_slip_diagnosed_observer", "slipstack, diagnosed, observer");
  observer.make = [](const Workshop& w, const ContenderName& n) { return w.with_observer(w.diagnosed(n)); };
  return {alone, observer};
}

std::vector<Maker> makers_of(Field field) {
  std::vector<Maker> makers = few();
  if (field == Field::kFew) return makers;
  const auto append = [&](std::vector<Maker> more) {
    for (Maker& one : more) makers.push_back(std::move(one));
  };
  const Maker ours = makers.back();
  makers.pop_back();
  append(peers());
  makers.push_back(ours);
  append(ours_with_more());
  if (field == Field::kWithEffects) {
    append(diagnosed());
    return makers;
  }
  append({bound("bound", "bound: friction known", 1.0, 1.0),
          bound("bound_quiet", "bound, no noise", 0.0, 1.0),
          bound("bound_fine", "bound, fine encoder", 1.0, 0.01)});
  return makers;
}

}  // namespace

std::vector<ContenderName> contenders_of(Field field) {
  std::vector<ContenderName> names;
  for (const Maker& maker : makers_of(field)) names.push_back(maker.name);
  return names;
}

std::vector<Contender> tuned_contenders(const sim::Axis& axis, std::uint64_t seed, Field field,
                                        const std::function<void(double)>& progress) {
  const Workshop workshop(axis, seed);
  const std::vector<Maker> makers = makers_of(field);
  std::vector<Contender> made(makers.size());
  std::atomic<std::size_t> done{0};
  parallel_for(makers.size(), [&](std::size_t i) {
    made[i] = makers[i].make(workshop, makers[i].name);
    progress(static_cast<double>(++done) / static_cast<double>(makers.size()));
  });
  return made;
}

}  // namespace slipstack::workbench
