#pragma once

#include "scene/outcome_probe.hpp"
#include "scene/stage_run.hpp"
#include "sim/archive.hpp"

/// The state of stages in a checkpoint.
namespace palpate {

template <class Archive>
void serialize(Archive& archive, PlacedOverlap& overlap) {
  archive(overlap.placed, overlap.other, overlap.contacts, overlap.deepest);
}

template <class Archive>
void serialize(Archive& archive, StageEnding& ending) {
  archive(ending.step, ending.reached, ending.overlaps);
}

template <class Archive>
void serialize(Archive& archive, OutcomeValue& value) {
  archive(value.value, value.vector);
}

template <class Archive>
void serialize(Archive& archive, StageProgress& progress) {
  archive(progress.endings, progress.begun);
}

}  // namespace palpate
