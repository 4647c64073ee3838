// SPDX-License-Identifier: Apache-2.0
// libFuzzer's entry point; OVOID_FUZZ_TARGET names the function of targets.h.
#include "fuzz/targets.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  ovoid::fuzz::OVOID_FUZZ_TARGET({reinterpret_cast<const std::byte*>(data), size});
  return 0;
}
