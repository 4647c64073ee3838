// SPDX-License-Identifier: Apache-2.0
// ovoid view: hands over to the viewer, a program of its own, so that drawing to files needs no
// library for windows.

#include <fmt/format.h>

#include "command.h"
#include "other_program.h"
#include "ovoid/error.h"

namespace ovoid::cli {

void run_view(const Words& words) {
  const auto [viewer, is_there] = program_beside("ovoid-viewer");
  if (!is_there) {
    throw Error(ErrorCode::kUnsupported,
                fmt::format("view: the viewer is not part of this installation, there is no {}: in "
                            "the source folder, make build makes it; to draw to a file: ovoid "
                            "render INPUT... -o OUT.png",
                            viewer));
  }
  become(viewer, words, "view");
}

}  // namespace ovoid::cli
