// SPDX-License-Identifier: Apache-2.0
// The desktop's own dialog for files: a program beside the window, zenity or kdialog. Neither is
// linked, and neither is needed.
#pragma once

#include <sys/types.h>

#include <optional>
#include <string>
#include <vector>

namespace ovoid::viewer {

class FileDialog {
 public:
  FileDialog() = default;
  ~FileDialog();  // ends the program
  FileDialog(const FileDialog&) = delete;
  FileDialog& operator=(const FileDialog&) = delete;

  struct Question {
    std::string title;
    std::string folder;         // at first
    bool takes_several = true;  // files
  };
  // Shows the dialog; nothing happens while one is shown. Throws Error(kUnsupported), with the way
  // out, where there is no such program.
  void show(const Question& question);
  bool is_shown() const noexcept { return child_ > 0; }

  struct Answer {
    std::vector<std::string> paths;  // none: the person wants no file
    std::string error;               // why the dialog has failed; empty: it has not
  };
  // What was chosen, once; empty as long as nothing is. Does not wait.
  std::optional<Answer> take();

 private:
  void read();
  void close() noexcept;

  pid_t child_ = -1;
  int output_ = -1;  // its standard output, for us to read
  std::string name_;
  std::string text_;
};

}  // namespace ovoid::viewer
