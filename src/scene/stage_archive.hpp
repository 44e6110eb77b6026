#pragma once

#include "scene/stage_run.hpp"
#include "sim/archive.hpp"

/// The state of stages in a checkpoint.
namespace palpate {

template <class Archive>
void describe(Archive& archive, StageEnding& ending) {
  archive(ending.step, ending.reached);
}

template <class Archive>
void describe(Archive& archive, StageProgress& progress) {
  archive(progress.endings, progress.begun);
}

}  // namespace palpate
