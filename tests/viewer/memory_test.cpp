// SPDX-License-Identifier: Apache-2.0
// The list of what was opened last, without a window.
#include "memory.h"

#include <gtest/gtest.h>

#include <chrono>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <thread>

#include "cli/program.h"

namespace ovoid::viewer {
namespace memory_test {

// A disk that does not answer until it is told to; then nothing on it is there.
class DeadDisk {
 public:
  bool is_there(const std::string& path) {
    if (!path.starts_with("/dead/")) return true;
    std::unique_lock lock(mutex_);
    ++num_asked_;
    awake_.wait(lock, [this] { return answers_; });
    return false;
  }
  void answer() {
    const std::lock_guard lock(mutex_);
    answers_ = true;
    awake_.notify_all();
  }
  int num_asked() {
    const std::lock_guard lock(mutex_);
    return num_asked_;
  }

 private:
  std::mutex mutex_;
  std::condition_variable awake_;
  bool answers_ = false;
  int num_asked_ = 0;
};

// Until it is so, or for ten seconds.
template <class Condition>
bool comes_about(const Condition& condition) {
  for (int i = 0; i < 1000; ++i) {
    if (condition()) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  return false;
}

cli::DataFlags input(const std::string& path) {
  cli::DataFlags data;
  data.inputs = {path};
  return data;
}

// Hangs if the list waits for the disk; fails if it never learns what the disk has said, or if each
// look at the list asks once more.
TEST(Memory, ADiskThatDoesNotAnswerHoldsNobodyUp) {
  const cli_tests::Folder folder;
  const std::string path = folder / "window.json";
  const auto disk = std::make_shared<DeadDisk>();
  const auto question = [disk](const std::string& asked) { return disk->is_there(asked); };
  {
    Memory before(path, [](const std::string&) { return true; });
    before.add_recent(recent_input(input("/dead/a.nrrd")));
    before.add_recent(recent_input(input("/alive/b.nrrd")));
  }
  Memory memory(path, question);
  ASSERT_EQ(memory.recent().size(), 2U);
  EXPECT_TRUE(memory.recent()[1].is_there);  // as far as is known
  ASSERT_TRUE(comes_about([&] { return disk->num_asked() == 1; }));
  memory.add_recent(recent_input(input("/alive/c.nrrd")));  // reads the list again
  EXPECT_EQ(memory.recent().size(), 3U);
  ASSERT_TRUE(comes_about([&] { return memory.update(); }));  // of what is alive
  EXPECT_TRUE(memory.recent()[2].is_there);
  EXPECT_EQ(disk->num_asked(), 1);
  disk->answer();
  EXPECT_TRUE(comes_about([&] {
    memory.update();
    return !memory.recent()[2].is_there;
  }));
  EXPECT_TRUE(memory.recent()[0].is_there);
  EXPECT_TRUE(memory.recent()[1].is_there);
}

// Nobody waits for an answer that never comes.
TEST(Memory, EndsWithoutAnAnswer) {
  const auto disk = std::make_shared<DeadDisk>();
  {
    FileFinder finder([disk](const std::string& asked) { return disk->is_there(asked); });
    finder.look_for({"/alive/a", "/dead/b"});
    finder.look_for({"/alive/a"});
    ASSERT_TRUE(comes_about([&] { return finder.are_there({"/alive/a"}).has_value(); }));
    EXPECT_EQ(finder.are_there({"/alive/a", "/dead/b"}), std::nullopt);
    ASSERT_TRUE(comes_about([&] { return disk->num_asked() == 1; }));
  }
  disk->answer();
}

}  // namespace memory_test
}  // namespace ovoid::viewer
