// SPDX-License-Identifier: Apache-2.0
// ovoid-mpi: what `mpirun -n N ovoid render` becomes, so that drawing alone needs no MPI.

#include <fcntl.h>
#include <fmt/format.h>
#include <malloc.h>
#include <mpi.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <optional>
#include <string>

#include "command.h"
#include "console.h"
#include "interrupt.h"
#include "mpi_team.h"
#include "ovoid/error.h"
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
    return team.number() == 0 ? complain(error.what(), error.exit_code()) : error.exit_code();
  }
  return kExitFailed;
}

// A launcher of another MPI than this program's starts processes that each see themselves alone.
void require_own_launcher(const Team& team) {
  const char* const text = std::getenv(kProcessesOfLauncher);
  if (text == nullptr || std::atoi(text) == team.count()) return;
  char version[MPI_MAX_LIBRARY_VERSION_STRING] = "";
  int length = 0;
  MPI_Get_library_version(version, &length);
  throw Error(ErrorCode::kUnsupported,
              fmt::format("render: {} processes were started, but the MPI that ovoid-mpi was built "
                          "with sees {}: use the launcher of {}",
                          text, team.count(), std::string(version).substr(0, 40)));
}

void silence_standard_output() {
  const int nothing = open("/dev/null", O_WRONLY);
  if (nothing < 0) return;
  dup2(nothing, STDOUT_FILENO);
  close(nothing);
}

int run(int argc, char** argv) {
  hold_standard_files();
#ifdef M_MMAP_THRESHOLD
  // What has been sent goes back to the system at once: other processes of the machine take as
  // much.
  mallopt(M_MMAP_THRESHOLD, 1 << 20);
#endif
  int exit_code = kExitFailed;
  try {
    const Words words(argv, argv + argc);
    // Before MPI starts threads of its own, which would take Ctrl-C otherwise.
    Session session(words);
    int granted = MPI_THREAD_SINGLE;
    MPI_Init_thread(&argc, &argv, MPI_THREAD_MULTIPLE, &granted);
    try {
      MpiTeam team(MpiTeam::Duration(patience_of_environment()), granted == MPI_THREAD_MULTIPLE);
      if (team.number() != 0) silence_standard_output();
      require_own_launcher(team);
      exit_code = run_in_team({words.begin() + 1, words.end()}, team, session);
      flush_out();
    } catch (...) {
      exit_code = speaks_for_all() ? complain_of_exception() : failure_of_exception().exit_code;
    }
    // All is said. Launchers end those that are slower than the first that failed.
    Interrupt::be_silent();
    MPI_Finalize();
  } catch (...) {
    exit_code = complain_of_exception();
  }
  std::fflush(stdout);
  _exit(exit_code);  // as the program itself ends
}

}  // namespace
}  // namespace ovoid::cli

int main(int argc, char** argv) { return ovoid::cli::run(argc, argv); }
