#pragma once

/// Includes the whole library. Single headers compile faster.
#include <palpate/detection.hpp>
#include <palpate/error.hpp>
#include <palpate/fibres.hpp>
#include <palpate/forces.hpp>
#include <palpate/material.hpp>
#include <palpate/mesh.hpp>
#include <palpate/model.hpp>
#include <palpate/outcomes.hpp>
#include <palpate/relax.hpp>
#include <palpate/settings.hpp>
#include <palpate/simulation.hpp>
#include <palpate/tissue.hpp>
#include <palpate/tissues.hpp>
#include <palpate/types.hpp>
#include <palpate/version.hpp>
