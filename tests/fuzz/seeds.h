// SPDX-License-Identifier: Apache-2.0
// Small valid inputs for each family of readers, made here: where fuzzing and the mutation test
// start from.
#pragma once

#include "fuzz/look_seeds.h"
#include "fuzz/mesh_seeds.h"
#include "fuzz/point_seeds.h"
#include "fuzz/volume_seeds.h"
