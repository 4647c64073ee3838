// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace ovoid::viewer {

// How much nicer than the interface a thread is, as nice(1) counts.
inline constexpr int kNicer = 6;       // a quarter of the time, where both want the same processor
inline constexpr int kMuchNicer = 15;  // a seventh of the time of what is nicer by kNicer

// Lets the interface go first: the calling thread, and those that it starts, give way to it. Where
// the system has no such thing, nothing happens.
void lower_priority(int nicer = kNicer) noexcept;

}  // namespace ovoid::viewer
