// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace ovoid::viewer {

// How much nicer than the interface a thread is, as nice(1) counts.
inline constexpr int kNicer = 6;  // a quarter of the time, where both want the same processor
// Under a third of the time where something nicer by kNicer wants the same processor, and a tenth
// of it beside another program's thread: work in the background goes on while a machine is busy.
inline constexpr int kMuchNicer = 10;

// Lets the interface go first: the calling thread, and those that it starts, give way to it. Where
// the system has no such thing, nothing happens.
void lower_priority(int nicer = kNicer) noexcept;

}  // namespace ovoid::viewer
