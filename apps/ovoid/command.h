// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "flags.h"
#include "session.h"

namespace ovoid::cli {

// One subcommand, one file. Each takes the words after its name, and throws UsageError or
// ovoid::Error.
void run_render(const Words& words, Session& session);
void run_composite(const Words& words, Session& session);
void run_animate(const Words& words, Session& session);
void run_info(const Words& words, Session& session);
void run_make(const Words& words, Session& session);
void run_convert(const Words& words, Session& session);
void run_fit(const Words& words, Session& session);
void run_simplify(const Words& words, Session& session);
void run_sample(const Words& words, Session& session);
void run_bench(const Words& words, Session& session);

// Becomes the viewer, the program ovoid-viewer that lies beside this one, and hands it the words.
// Throws Error(kUnsupported) if it is not there.
[[noreturn]] void run_view(const Words& words);

// How many processes mpirun, mpiexec or srun has started, this among them; 0: none of these has
// started this, or OVOID_MPI is 0.
int processes_by_mpi();

// Whether this is the process that tells what is wrong with all of them.
bool speaks_for_all();
// In the environment of ovoid-mpi: how many processes the launcher has started, which its own MPI
// must see, too.
inline constexpr const char* kProcessesOfLauncher = "OVOID_MPI_PROCESSES";

// Becomes ovoid-mpi, which lies beside this program, and hands it the words. Throws UsageError for
// other commands than render, Error(kUnsupported) if it is not there.
[[noreturn]] void run_with_mpi(const Words& words);

// How the flags of render are given.
const std::vector<FlagForm>& render_flags();

// Throws UsageError for what render would refuse of these flags before it reads a file: values, and
// what contradicts itself. No inputs and no output are needed; nothing is opened.
void check_render_flags(const Words& flag_words);

}  // namespace ovoid::cli
