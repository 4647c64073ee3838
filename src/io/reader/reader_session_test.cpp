// SPDX-License-Identifier: Apache-2.0
// The process that reads with other people's libraries: what it may open, what becomes of crashes
// and endless loops, and what its host does not notice. Every test fails if the reading is done
// within the library's own process.
#include "io/reader/reader_session.h"

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <stop_token>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "io/core/test_folder.h"
#include "io/core/work_done.h"
#include "io/images/test_volumes.h"
#include "io/reader/reader_program.h"
#include "ovoid/io.h"
#include "ovoid/series.h"

namespace ovoid::io {
namespace reader_session_test {

namespace fs = std::filesystem;

std::string vtu(const std::string& value) {
  return R"(<VTKFile type="UnstructuredGrid"><UnstructuredGrid>
<Piece NumberOfPoints="4" NumberOfCells="1">
<PointData><DataArray type="Float32" Name="v" format="ascii">1 2 3 )" +
         value + R"(</DataArray></PointData>
<Points><DataArray type="Float32" NumberOfComponents="3" format="ascii">
0 0 0 1 0 0 0 1 0 0 0 1</DataArray></Points>
<Cells><DataArray type="Int64" Name="connectivity" format="ascii">0 1 2 3</DataArray>
<DataArray type="Int64" Name="offsets" format="ascii">4</DataArray>
<DataArray type="UInt8" Name="types" format="ascii">10</DataArray></Cells>
</Piece></UnstructuredGrid></VTKFile>)";
}

std::string pieces(const std::string& name) {
  return R"(<VTKFile type="PUnstructuredGrid"><PUnstructuredGrid GhostLevel="0"><Piece Source=")" +
         name + R"("/></PUnstructuredGrid></VTKFile>)";
}

// A polyhedron one of whose faces says that it has more corners than there are numbers: VTK 9.1
// reads on where there is nothing.
const std::string kCrash =
    R"(<VTKFile type="UnstructuredGrid"><UnstructuredGrid>
<Piece NumberOfPoints="4" NumberOfCells="1">
<PointData><DataArray type="Float32" Name="v" format="ascii">1 2 3 4</DataArray></PointData>
<Points><DataArray type="Float32" NumberOfComponents="3" format="ascii">
0 0 0 1 0 0 0 1 0 0 0 1</DataArray></Points>
<Cells><DataArray type="Int64" Name="connectivity" format="ascii">0 1 2 3</DataArray>
<DataArray type="Int64" Name="offsets" format="ascii">4</DataArray>
<DataArray type="UInt8" Name="types" format="ascii">42</DataArray>
<DataArray type="Int64" Name="faces" format="ascii">4 300000000 0 1 2 3 0 1 3 3 1 2 3 3 0 2 3</DataArray>
<DataArray type="Int64" Name="faceoffsets" format="ascii">17</DataArray></Cells>
</Piece></UnstructuredGrid></VTKFile>)";

// VTK 9.1 looks for a section that never comes.
const std::string kEndless =
    "FORMAT\ntype: ensight gold\nGEOMETRY\nmodel: a.geo\nVARIABL\nscalar per node: v a.v\n";

class ReaderSessionTest : public testing::Test {
 protected:
  void SetUp() override {
    if (error_of([&] { read("probe.vtu", vtu("4")); }).find("no VTK") != std::string::npos)
      GTEST_SKIP() << "this build has no VTK";
  }

  Dataset read(const std::string& name, const std::string& content,
               const ReadOptions& options = {}) const {
    return read_dataset({folder.write(name, content)}, options);
  }
  std::string refusal(const std::string& path, const ReadOptions& options = {}) const {
    return error_of([&] { read_dataset({path}, options); });
  }

  TestFolder folder;
};

std::size_t num_open_files() {
  return static_cast<std::size_t>(std::distance(fs::directory_iterator("/proc/self/fd"), {}));
}

TEST_F(ReaderSessionTest, CrashIsOneLine) {
  const std::string path = folder.write("crash.vtu", kCrash);
  const std::string message = refusal(path);
  EXPECT_TRUE(message.starts_with("file-format: " + path + ": its reader stopped")) << message;
  EXPECT_EQ(message.find('\n'), std::string::npos);
}

TEST_F(ReaderSessionTest, SessionOutlivesACrash) {
  const std::string good = folder.write("a.vtu", vtu("4")), bad = folder.write("crash.vtu", kCrash);
  ReadOptions options;
  options.session = std::make_shared<ReaderSession>(std::vector{good, bad});
  EXPECT_EQ(read_dataset({good}, options).array().name, "v");
  EXPECT_NE(refusal(bad, options), "");
  EXPECT_EQ(read_dataset({good}, options).array().name, "v");
}

TEST_F(ReaderSessionTest, EndlessLoopIsEnded) {
  folder.write("a.geo", "x\n");
  folder.write("a.v", "x\n");
  const std::string message = refusal(folder.write("a.case", kEndless));
  EXPECT_NE(message.find("processor time"), std::string::npos) << message;
}

// A polyhedron one of whose faces says that it has 2^40 corners. VTK 9.1 walks into its own set of
// nodes, which it fills meanwhile, and has told before that three quarters of the file are read.
std::string endless_polyhedron() {
  const auto big_endian = [](std::uint64_t number, int size) {
    std::string bytes;
    for (int shift = 8 * (size - 1); shift >= 0; shift -= 8)
      bytes += static_cast<char>((number >> static_cast<unsigned>(shift)) & 0xFFU);
    return bytes;
  };
  constexpr int kNumbers = 5000;
  std::string text = "# vtk DataFile Version 5.1\nx\nBINARY\nDATASET UNSTRUCTURED_GRID\n";
  text += "POINTS 8 float\n" + std::string(std::size_t{8} * 3 * 4, '\0');
  text += "\nCELLS 2 5000\nOFFSETS vtktypeint64\n" + big_endian(0, 8) + big_endian(kNumbers, 8);
  text += "\nCONNECTIVITY vtktypeint64\n" + big_endian(1, 8);
  text += big_endian(std::uint64_t{1} << 40U, 8);
  for (std::uint64_t i = 0; i < kNumbers - 2; ++i) text += big_endian(i * 7919 % 100000, 8);
  text += "\nCELL_TYPES 1\n" + big_endian(42, 4) + "\nPOINT_DATA 8\nSCALARS v float 1\n";
  text += "LOOKUP_TABLE default\n";
  for (std::uint32_t i = 0; i < 8; ++i) text += big_endian(0x3F800000 + i, 4);
  return text + "\n";
}

double seconds_of_children() {
  rusage used{};
  ::getrusage(RUSAGE_CHILDREN, &used);
  const auto seconds = [](const timeval& time) {
    return static_cast<double>(time.tv_sec) + static_cast<double>(time.tv_usec) * 1e-6;
  };
  return seconds(used.ru_utime) + seconds(used.ru_stime);
}

// Fails if what a library says of its progress earns it time: 300 s of a processor, for 48 KB.
TEST_F(ReaderSessionTest, ProgressEarnsNoTime) {
  const std::string path = folder.write("loop.vtk", endless_polyhedron());
  const double before = seconds_of_children();
  const std::string message = refusal(path);
  EXPECT_NE(message.find("its reader stopped"), std::string::npos) << message;
  EXPECT_LT(seconds_of_children() - before, 8);  // 2, a second's grace, and what it takes to start
}

// Fails if work earns nothing, or more than once.
TEST(WorkDone, IsToldInPieces) {
  std::vector<std::int64_t> told;
  set_work_listener([&](std::int64_t num_bytes) { told.push_back(num_bytes); });
  add_work_done(kWorkTold - 1);
  EXPECT_TRUE(told.empty());
  add_work_done(-5);
  add_work_done(1);
  add_work_done(3 * kWorkTold);
  set_work_listener({});
  add_work_done(5 * kWorkTold);
  EXPECT_EQ(told, (std::vector<std::int64_t>{kWorkTold, 3 * kWorkTold}));
}

TEST_F(ReaderSessionTest, StopEndsAnEndlessLoop) {
  folder.write("a.geo", "x\n");
  folder.write("a.v", "x\n");
  std::stop_source source;
  ReadOptions options;
  options.stop = source.get_token();
  std::jthread stopper([&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(300));
    source.request_stop();
  });
  EXPECT_EQ(refusal(folder.write("a.case", kEndless), options),
            "cancelled: reading: stopped by the caller");
}

// Fails if a stop that comes with the answer leaves a dead process to the next read.
TEST_F(ReaderSessionTest, SessionOutlivesAStopAtAnyTime) {
  const std::string path = folder.write("a.vtu", vtu("4"));
  ReadOptions plain;
  plain.session = std::make_shared<ReaderSession>(std::vector{path});
  read_dataset({path}, plain);
  const auto begin = std::chrono::steady_clock::now();
  read_dataset({path}, plain);
  const auto whole = std::chrono::steady_clock::now() - begin;
  constexpr int kTimes = 40;
  for (int i = 0; i < kTimes; ++i) {
    std::stop_source source;
    ReadOptions stopped = plain;
    stopped.stop = source.get_token();
    std::jthread stopper([&] {
      std::this_thread::sleep_for(whole * i / (kTimes / 2));
      source.request_stop();
    });
    const std::string message = error_of([&] { read_dataset({path}, stopped); });
    EXPECT_TRUE(message.empty() || message == "cancelled: reading: stopped by the caller")
        << message;
    EXPECT_EQ(error_of([&] { read_dataset({path}, plain); }), "") << i;
  }
}

// Every input stays as it was read, whatever becomes of the session and of other arrays.
TEST_F(ReaderSessionTest, ArraysOutliveTheProcess) {
  Dataset dataset;
  {
    ReadOptions options;
    const std::string path = folder.write("a.vtu", vtu("4"));
    options.session = std::make_shared<ReaderSession>(std::vector{path});
    dataset = read_dataset({path}, options);
  }
  const DataArray kept = dataset.array("v");
  dataset = {};
  EXPECT_EQ(values_of<float>(kept), (std::vector<float>{1, 2, 3, 4}));
}

// --- what may be opened -------------------------------------------------------------------------

TEST_F(ReaderSessionTest, PiecesElsewhereNeedLeave) {
  fs::create_directories(folder.file("own"));
  fs::create_directories(folder.file("other"));
  folder.write("own/p.vtu", vtu("4"));
  folder.write("other/p.vtu", vtu("5"));
  EXPECT_EQ(refusal(folder.write("own/a.pvtu", pieces("p.vtu"))), "");
  const std::string path = folder.write("own/b.pvtu", pieces("../other/p.vtu"));
  const std::string message = refusal(path);
  const std::string other = fs::canonical(folder.file("other")).string();
  EXPECT_TRUE(message.starts_with("unsupported: " + path)) << message;
  EXPECT_TRUE(message.ends_with("allow that with --data-folder '" + other + "'")) << message;
  ReadOptions options;
  options.data_folders = {other};
  EXPECT_EQ(values_of<float>(read_dataset({path}, options).array("v")).back(), 5);
}

// As VTK reads them: streams take a plus sign and blanks.
TEST_F(ReaderSessionTest, PiecesMayCountWithASign) {
  const std::string piece = with(vtu("4"), "NumberOfPoints=\"4\"", "NumberOfPoints=\" +4 \"");
  folder.write("p.vtu", with(piece, "NumberOfCells=\"1\"", "NumberOfCells=\"+1\""));
  EXPECT_EQ(refusal(folder.write("a.pvtu", pieces("p.vtu"))), "");
}

// A link in the folder leads out of it as well as ".." does; the input itself may be a link.
TEST_F(ReaderSessionTest, LinksAreFollowedFirst) {
  fs::create_directories(folder.file("own"));
  fs::create_directories(folder.file("other"));
  folder.write("other/p.vtu", vtu("4"));
  fs::create_symlink("../other/p.vtu", folder.file("own/p.vtu"));
  EXPECT_EQ(refusal(folder.file("own/p.vtu")), "");
  EXPECT_NE(refusal(folder.write("own/a.pvtu", pieces("p.vtu"))).find("--data-folder"),
            std::string::npos);
}

TEST_F(ReaderSessionTest, HeadersOfSamplesToo) {
  fs::create_directories(folder.file("own"));
  folder.write("secret", "passwords");
  const std::string header =
      "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 3 3 1\nencoding: raw\ndata file: ../secret\n";
  const std::string message = refusal(folder.write("own/a.nhdr", header));
  EXPECT_NE(message.find("--data-folder"), std::string::npos) << message;
  ReadOptions options;
  options.data_folders = {folder.file("")};
  EXPECT_EQ(refusal(folder.file("own/a.nhdr"), options), "");
}

// Opening a pipe, or a device, may do something to whoever is at its other end. Fails if anything
// but names decides.
TEST_F(ReaderSessionTest, FilesOfOtherFoldersAreRefusedUnopened) {
  fs::create_directories(folder.file("own"));
  const std::string pipe = folder.file("pipe");
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  fs::create_symlink(pipe, folder.file("own/link"));
  const auto root = [](const std::string& type, const std::string& content) {
    return "<VTKFile type=\"" + type + "\"><" + type + ">" + content + "</" + type + "></VTKFile>";
  };
  int number = 0;
  for (const std::string& name : {std::string("../pipe"), std::string("link"), pipe}) {
    const std::string file = "<DataSet index=\"0\" file=\"" + name + "\"/>";
    const std::vector<std::pair<std::string, std::string>> inputs{
        {"pvtu", pieces(name)},
        {"vtm", root("vtkMultiBlockDataSet", file)},
        {"vtpc", root("vtkPartitionedDataSetCollection", "<Partitions>" + file + "</Partitions>")},
        {"vtpd", root("vtkPartitionedDataSet", file)},
        {"pvd", root("Collection", file)},
        {"vthb", root("vtkOverlappingAMR", "<Block level=\"0\">" + file + "</Block>")},
        {"pvti", R"(<VTKFile type="PImageData"><PImageData WholeExtent="0 1 0 1 0 1"><Piece )"
                 R"(Extent="0 1 0 1 0 1" Source=")" +
                     name + R"("/></PImageData></VTKFile>)"},
        {"vtu.series", R"({"file-series-version": "1.0", "files": [{"name": ")" + name + R"("}]})"},
    };
    for (const auto& [ending, content] : inputs) {
      const std::string path =
          folder.write("own/a" + std::to_string(number++) + "." + ending, content);
      EXPECT_NE(refusal(path).find("outside its folder"), std::string::npos) << path;
      // A set within a set.
      const std::string outer = folder.write(
          "own/b.vtm",
          root("vtkMultiBlockDataSet",
               "<DataSet index=\"0\" file=\"" + fs::path(path).filename().string() + "\"/>"));
      EXPECT_NE(refusal(outer).find("outside its folder"), std::string::npos) << path;
    }
  }
  ::unlink(folder.file("own/link").c_str());
  ASSERT_EQ(::mkfifo(folder.file("own/link").c_str(), 0600), 0);
  EXPECT_NE(refusal(folder.write("own/c.pvtu", pieces("link"))), "");  // and does not hang
}

TEST_F(ReaderSessionTest, DataFolderMustBeThere) {
  ReadOptions options;
  options.data_folders = {folder.file("nowhere")};
  EXPECT_EQ(refusal(folder.write("a.vtu", vtu("4")), options),
            "file-not-found: data folder '" + folder.file("nowhere") + "': is no folder");
}

TEST_F(ReaderSessionTest, FilesOfSetsAndCases) {
  fs::create_directories(folder.file("a"));
  const std::string inner = folder.write("a/p.vtu", vtu("4"));
  const std::string set = folder.write("a.pvtu", pieces("a/p.vtu"));
  EXPECT_EQ(files_read_for(set), (std::vector{set, inner}));
  const std::string series = folder.write(
      "a.pvd",
      R"(<VTKFile type="Collection"><Collection><DataSet timestep="0" file="a.pvtu"/></Collection></VTKFile>)");
  EXPECT_EQ(files_read_for(series), (std::vector{series, set, inner}));
  const std::string geometry = folder.write("a.geo", "x");
  const std::string first = folder.write("v001", "x"), second = folder.write("v002", "x");
  folder.write("v00x", "x");
  const std::string input = folder.write("a.case",
                                         "FORMAT\ntype: ensight gold\nGEOMETRY\nmodel: a.geo\n"
                                         "VARIABLE\nscalar per node: v v***\n");
  EXPECT_EQ(files_read_for(input), (std::vector{input, geometry, first, second}));
  const std::string enzo =
      folder.write("e.hierarchy",
                   "Grid = 1\nBaryonFileName = /far/away/e.cpu0000\nNumberOfParticles   = 4962\n");
  const std::string start = folder.write("e", "InitialTime = 0\n");
  const std::string grid = folder.write("e.cpu0000", "x");
  EXPECT_EQ(files_read_for(enzo), (std::vector{enzo, start, grid}));
}

// --- what is loaded

// The folder that a program works in may be that of other people's data.
void write_wrong_libraries(const TestFolder& folder) {
  for (const char* const name : {"libc.so.6", "libm.so.6", "libstdc++.so.6", "libblosc.so.1"})
    folder.write(name, "no library");
}

// Fails if an entry of LD_LIBRARY_PATH leads the reader's loader into the working folder.
TEST_F(ReaderSessionTest, LibrariesOfTheWorkingFolderAreNotLoaded) {
  const std::string path = folder.write("a.vtu", vtu("4"));
  write_wrong_libraries(folder);
  const fs::path before = fs::current_path();
  const char* const variable = std::getenv("LD_LIBRARY_PATH");
  const std::string kept = variable != nullptr ? variable : "";
  for (const char* const entries : {"", ":", ".", "/nowhere::", "/nowhere;;.", "./"}) {
    ::setenv("LD_LIBRARY_PATH", entries, 1);
    fs::current_path(folder.file(""));
    EXPECT_EQ(refusal(path), "") << entries;
  }
  fs::current_path(before);
  variable != nullptr ? ::setenv("LD_LIBRARY_PATH", kept.c_str(), 1)
                      : ::unsetenv("LD_LIBRARY_PATH");
}

TEST(ReaderEnvironment, HasTheAbsoluteFoldersOfLibraries) {
  const auto libraries = [](const char* path) {
    std::vector<std::string> found;
    for (const std::string& variable : reader_environment(path))
      if (!variable.starts_with("GLIBC_TUNABLES=")) found.push_back(variable);
    return found;
  };
  for (const char* const none : {"", ":", ".", "lib:$ORIGIN/../lib", ":./lib;"})
    EXPECT_TRUE(libraries(none).empty()) << none;
  EXPECT_TRUE(libraries(nullptr).empty());
  EXPECT_EQ(libraries("/opt/a/lib"), std::vector<std::string>{"LD_LIBRARY_PATH=/opt/a/lib"});
  EXPECT_EQ(libraries(":/opt/a;.;/opt/b:"),
            std::vector<std::string>{"LD_LIBRARY_PATH=/opt/a:/opt/b"});
}

// --- what the host does not notice --------------------------------------------------------------

TEST_F(ReaderSessionTest, HostIsLeftAsItWas) {
  folder.write("warm.vtu", vtu("4"));
  EXPECT_EQ(refusal(folder.file("warm.vtu")), "");
  const std::size_t num_before = num_open_files();
  for (int i = 0; i < 3; ++i) {
    EXPECT_EQ(refusal(folder.file("warm.vtu")), "");
    EXPECT_NE(refusal(folder.write("crash.vtu", kCrash)), "");
  }
  EXPECT_EQ(num_open_files(), num_before);
  EXPECT_EQ(::waitpid(-1, nullptr, WNOHANG), -1) << "a child is left";
  for (const int signal : {SIGCHLD, SIGPIPE, SIGTERM}) {
    struct sigaction action {};
    ::sigaction(signal, nullptr, &action);
    EXPECT_EQ(action.sa_handler, SIG_DFL) << signal;
  }
}

// As some servers do, whose children are then gone before anybody can ask why they ended.
TEST_F(ReaderSessionTest, HostMayIgnoreItsChildren) {
  ::signal(SIGCHLD, SIG_IGN);
  const std::string good = refusal(folder.write("a.vtu", vtu("4")));
  const std::string bad = refusal(folder.write("crash.vtu", kCrash));
  ::signal(SIGCHLD, SIG_DFL);
  EXPECT_EQ(good, "");
  EXPECT_NE(bad.find("its reader stopped"), std::string::npos) << bad;
}

TEST_F(ReaderSessionTest, HostMayWaitForAllItsChildren) {
  std::atomic<bool> is_done = false;
  std::jthread waiter([&] {
    while (!is_done) ::waitpid(-1, nullptr, WNOHANG);
  });
  const std::string good = refusal(folder.write("a.vtu", vtu("4")));
  const std::string bad = refusal(folder.write("crash.vtu", kCrash));
  is_done = true;
  EXPECT_EQ(good, "");
  EXPECT_NE(bad.find("its reader stopped"), std::string::npos) << bad;
}

TEST_F(ReaderSessionTest, HostMayHaveClosedItsStandardFiles) {
  const std::string path = folder.write("a.vtu", vtu("4"));
  const pid_t child = ::fork();
  if (child == 0) {
    for (int fd = 0; fd < 3; ++fd) ::close(fd);
    ::_exit(refusal(path).empty() ? 0 : 1);
  }
  int status = -1;
  ::waitpid(child, &status, 0);
  EXPECT_EQ(status, 0);
}

TEST_F(ReaderSessionTest, ManyThreadsReadAtOnce) {
  std::vector<std::string> messages(6);
  {
    std::vector<std::jthread> threads;
    for (std::size_t i = 0; i < messages.size(); ++i) {
      const std::string path = folder.write("t" + std::to_string(i) + ".vtu", vtu("4"));
      threads.emplace_back([&messages, path, i, this] { messages[i] = refusal(path); });
    }
  }
  for (const std::string& message : messages) EXPECT_EQ(message, "");
}

TEST_F(ReaderSessionTest, MissingProgramIsNamed) {
  ReadOptions options;
  options.reader_program = "/nowhere/ovoid-read";
  const std::string missing = refusal(folder.write("a.vtu", vtu("4")), options);
  options.reader_program = "/bin/true";
  const std::string wrong = refusal(folder.file("a.vtu"), options);
  EXPECT_EQ(missing,
            "unsupported: reader_program = /nowhere/ovoid-read: is no program that can be started: "
            "expected ovoid-read");
  EXPECT_NE(wrong.find("its reader "), std::string::npos) << wrong;
}

// Steps of a series come from one process: the second is read although the program is gone.
TEST_F(ReaderSessionTest, SeriesKeepsItsProcess) {
  const std::vector<std::string> paths{folder.write("a0.vtu", vtu("4")),
                                       folder.write("a1.vtu", vtu("5"))};
  ReadOptions options;
  options.reader_program = folder.file("reader");
  fs::create_symlink(find_reader_program("a0.vtu", {}), options.reader_program);
  const auto steps = open_steps(paths, options);
  fs::remove(options.reader_program);
  EXPECT_EQ(error_of([&] { steps->read(1); }), "");
}

}  // namespace reader_session_test
}  // namespace ovoid::io
