// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace ovoid::viewer {

// Lets the interface go first: the calling thread, and those that it starts, give way to it. Where
// the system has no such thing, nothing happens.
void lower_priority() noexcept;

}  // namespace ovoid::viewer
