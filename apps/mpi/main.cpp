// SPDX-License-Identifier: Apache-2.0
// ovoid-mpi: what `mpirun -n N ovoid render` becomes, so that drawing alone needs no MPI.

#include <fmt/format.h>
#include <mpi.h>
#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <optional>
#include <string>

#include "command.h"
#include "console.h"
#include "mpi_team.h"
#include "session.h"
#include "setting_forms.h"
#include "usage.h"
#include "values.h"

namespace ovoid::cli {
namespace {

constexpr double kPatience = 600;  // seconds

double patience_of_environment() {
  const char* const text = std::getenv("OVOID_MPI_WAIT");
  if (text == nullptr) return kPatience;
  try {
    return parse_number(text, kPositive);
  } catch (const BadValue& bad) {
    throw UsageError(fmt::format("OVOID_MPI_WAIT '{}': {}", text, bad.what()));
  }
}

// The first process speaks for all.
int run_in_team(const Words& words, Team& team, Session& session) {
  std::optional<Quiet> quiet;
  if (team.number() != 0) quiet.emplace(session);
  session.join(team);
  try {
    try {
      run_render(words, session);
      team.meet();
      return kExitDone;
    } catch (const TeamError&) {
      throw;
    } catch (...) {
      const auto [message, exit_code] = failure_of_exception();
      team.meet(message, exit_code);  // throws
    }
  } catch (const TeamError& error) {
    if (team.number() == 0) complain(error.what(), error.exit_code());
    return error.exit_code();
  }
  return kExitFailed;
}

int run(int argc, char** argv) {
  hold_standard_files();
  const Words words(argv, argv + argc);
  // Before MPI starts threads of its own, which would take Ctrl-C otherwise.
  Session session(words);
  MPI_Init(&argc, &argv);
  int exit_code = kExitFailed;
  try {
    MpiTeam team{std::chrono::duration<double>(patience_of_environment())};
    exit_code = run_in_team({words.begin() + 1, words.end()}, team, session);
    flush_out();
  } catch (...) {
    exit_code = complain_of_exception();
  }
  MPI_Finalize();
  std::fflush(stdout);
  _exit(exit_code);  // as the program itself ends
}

}  // namespace
}  // namespace ovoid::cli

int main(int argc, char** argv) { return ovoid::cli::run(argc, argv); }
