// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <map>
#include <memory>
#include <new>
#include <set>
#include <string>
#include <tuple>
#include <type_traits>
#include <utility>
#include <vector>

#include "firmware/effects/model.h"
#include "workbench/c_export/record_model.h"
#include "workbench/c_export/recorded.h"
#include "workbench/c_export/recorded_effects.h"

namespace slipstack::workbench {

/// One effect's parameters; those beyond the elements of the target are zero.
template <class T, class E>
void take_parameters(const Terms& terms, EffectParameters<E, Recorded<T>>& parameters) {
  const Term* const term = find_term(terms, E::text.id);
  if (term == nullptr) return;
  parameters.enabled = true;
  const auto copy = [](const std::vector<double>& from, auto& to) {
    for (std::size_t i = 0; i < to.size() && i < from.size(); ++i) {
      to[i] = Recorded<T>(from[i]);
    }
  };
  copy(term->shapes, parameters.shapes);
  copy(term->gains, parameters.gains);
}

template <class T, class... Effects>
void take_all_parameters(const Terms& terms, std::tuple<EffectParameters<Effects, Recorded<T>>...>& all) {
  (take_parameters<T, Effects>(terms, std::get<EffectParameters<Effects, Recorded<T>>>(all)), ...);
}

/// A model in a place of its own: its members are the scalars that lie there.
template <class T, class EffectList>
class WatchedModel {
 public:
  explicit WatchedModel(ComputationRecord& recording) : recording_(recording) {
    place_.fill(std::byte{0});
    recording.watch(place_.data(), place_.size());
    model_ = new (place_.data()) FrictionModel<Recorded<T>, EffectList>;
  }
  ~WatchedModel() {
    model_->~FrictionModel();
    recording_.watch(nullptr, 0);
  }
  WatchedModel(const WatchedModel&) = delete;
  WatchedModel& operator=(const WatchedModel&) = delete;

  FrictionModel<Recorded<T>, EffectList>& model() { return *model_; }

  /// Scalars of the effects by their place, without the record of the last force.
  std::map<std::size_t, Recorded<T>*> members() const {
    const auto* const force = reinterpret_cast<const std::byte*>(&std::as_const(*model_).force());
    std::map<std::size_t, Recorded<T>*> found;
    for (void* const member : recording_.members()) {
      const auto* const byte = static_cast<const std::byte*>(member);
      if (byte >= force && byte < force + sizeof(typename FrictionModel<Recorded<T>, EffectList>::Force))
        continue;
      found.emplace(static_cast<std::size_t>(byte - place_.data()), static_cast<Recorded<T>*>(member));
    }
    return found;
  }

  /// All bytes that are not such a scalar.
  std::vector<std::byte> other_bytes() const {
    std::vector<std::byte> bytes(place_.begin(), place_.end());
    for (void* const member : recording_.members()) {
      const auto at = static_cast<std::ptrdiff_t>(static_cast<const std::byte*>(member) - place_.data());
      std::fill_n(bytes.begin() + at, sizeof(Recorded<T>), std::byte{0});
    }
    return bytes;
  }

 private:
  ComputationRecord& recording_;
  alignas(FrictionModel<Recorded<T>, EffectList>)
      std::array<std::byte, sizeof(FrictionModel<Recorded<T>, EffectList>)> place_;
  FrictionModel<Recorded<T>, EffectList>* model_ = nullptr;
};

template <class T>
Sample<Recorded<T>> given_motion(ComputationRecord& recording) {
  const auto given = [&recording](const char* name) {
    return Recorded<T>::of(recording.leaf(std::string("motion->") + name));
  };
  Sample<Recorded<T>> sample;
  sample.time_s = given("time_s");
  // In double the workbench's unit of displacement is the metre.
  sample.displacement = given(std::is_same_v<T, float> ? "position_steps" : "position_m");
  sample.position_m = given("position_m");
  sample.velocity_mps = given("velocity_mps");
  sample.acceleration_mps2 = given("acceleration_mps2");
  return sample;
}

/// What the tick changes is the state: first nothing is taken for state, then what has changed, until no more
/// does.
template <class T, class EffectList = Catalogue<Recorded<T>>>
class Recorder {
 public:
  Recorder(const Terms& terms, const ExportScales& scales)
      : recorded_{std::make_unique<ComputationRecord>(), {}, {}, 0, false}, watched_(*recorded_.recording) {
    typename FrictionModel<Recorded<T>, EffectList>::Parameters parameters;
    take_all_parameters<T>(terms, parameters);
    ComputationRecord& recording = *recorded_.recording;
    const Recorded<T> tick =
        scales.tick_s ? Recorded<T>(*scales.tick_s) : Recorded<T>::of(recording.leaf(kTickName));
    watched_.model().prepare(parameters, {tick, Recorded<T>(scales.metres_per_step)});
    motion_ = given_motion<T>(recording);
    watched_.model().reset(motion_);
    for (const auto& [place, member] : watched_.members()) first_.emplace(place, *member);
  }

  RecordedModel record() {
    while (advance_finds_state()) {
    }
    const typename FrictionModel<Recorded<T>, EffectList>::Force& force = watched_.model().force();
    recorded_.force_N = force.total_N.value();
    keep_effects(force, std::type_identity<EffectList>{});
    keep_used_memory();
    return std::move(recorded_);
  }

 private:
  /// One tick from the first state, with a name for each number that is known to be state.
  bool advance_finds_state() {
    const auto members = watched_.members();
    for (const auto& [place, member] : members) *member = first_.at(place);
    for (const auto& [place, name] : state_) *members.at(place) = Recorded<T>::of(name);
    std::map<std::size_t, Recorded<T>> before;
    for (const auto& [place, member] : members) before.emplace(place, *member);
    const std::vector<std::byte> others = watched_.other_bytes();
    watched_.model().advance(motion_);
    if (watched_.other_bytes() != others) throw NotRecordable("it remembers something else than a Real");
    bool found = false;
    for (const auto& [place, member] : members) {
      if (member->same_as(before.at(place)) || state_.contains(place)) continue;
      // Numbered by their order of discovery; unused ones are left out later.
      state_.emplace(place, recorded_.recording->leaf("@memory" + std::to_string(state_.size()) + "@"));
      found = true;
    }
    return found;
  }

  template <class... Effects>
  void keep_effects(const typename FrictionModel<Recorded<T>, EffectList>::Force& force,
                    std::type_identity<std::tuple<Effects...>>) {
    std::vector<RecordedModel::Effect> others;
    std::vector<RecordedModel::Effect> of_all;
    std::size_t index = 0;
    const auto keep = [&]<class E>(std::type_identity<E>) {
      const Recorded<T>& own = force.by_effect_N[index++];
      const auto acts_as = [](Acts acts) {
        return std::any_of(E::gains.begin(), E::gains.end(),
                           [acts](const GainGroup& g) { return g.acts == acts; });
      };
      RecordedModel::Effect effect{E::text, {}};
      if (!own.is_constant()) effect.force_N = own.value();
      auto& place = acts_as(Acts::dry) ? recorded_.effects : acts_as(Acts::total_scale) ? of_all : others;
      place.push_back(effect);
    };
    (keep(std::type_identity<Effects>{}), ...);
    recorded_.effects.insert(recorded_.effects.end(), others.begin(), others.end());
    recorded_.effects.insert(recorded_.effects.end(), of_all.begin(), of_all.end());
  }

  /// State that neither the force nor other state depends on is none.
  void keep_used_memory() {
    const ComputationRecord& recording = *recorded_.recording;
    const auto members = watched_.members();
    std::set<ValueId> used;
    recording.add_used(recorded_.force_N, used);
    std::set<std::size_t> kept;
    for (bool grows = true; grows;) {
      grows = false;
      for (const auto& [place, name] : state_) {
        if (!used.contains(name) || !kept.insert(place).second) continue;
        recording.add_used(members.at(place)->value(), used);
        recording.add_used(first_.at(place).value(), used);
        grows = true;
      }
    }
    for (const std::size_t place : kept) {
      recorded_.memory.push_back({state_.at(place), first_.at(place).value(), members.at(place)->value()});
    }
    recorded_.depends_on_tick = std::any_of(
        used.begin(), used.end(), [&](ValueId id) { return recording.values()[id].form == kTickName; });
  }

  RecordedModel recorded_;
  WatchedModel<T, EffectList> watched_;
  Sample<Recorded<T>> motion_;
  std::map<std::size_t, Recorded<T>> first_;  ///< members by place, after reset()
  std::map<std::size_t, ValueId> state_;      ///< places of what a tick changes, and their names
};

}  // namespace slipstack::workbench
