// SPDX-License-Identifier: Apache-2.0
// What readers have done so far, by which the readers' process earns its processor time.
#pragma once

#include <cstdint>
#include <functional>

namespace ovoid::io {

// Bytes of arrays that our own readers have read or made in this process, and those that a checked
// header shows another library will unpack. What a library says of its own progress is not counted:
// a damaged file makes it say so anything. From any thread. Cost: an addition.
void add_work_done(std::int64_t num_bytes);

// Tells `listener` of every so many bytes: how many there were since it was told last. One at a
// time, by the thread that does the work. An empty one ends that.
constexpr std::int64_t kWorkTold = std::int64_t{16} << 20;
void set_work_listener(std::function<void(std::int64_t num_bytes)> listener);

}  // namespace ovoid::io
