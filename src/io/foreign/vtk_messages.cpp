// SPDX-License-Identifier: Apache-2.0
#ifdef OVOID_IO_VTK

#include "io/foreign/vtk_messages.h"

#include <vtkLogger.h>
#include <vtkObjectFactory.h>
#include <vtkOutputWindow.h>
#include <vtkSmartPointer.h>

#include <mutex>
#include <string_view>
#include <thread>

namespace ovoid::io {
namespace {

// A file may make VTK say something about each of its lines.
constexpr std::size_t kMaxMessages = 100;

// "x (0x55) and y(0x55)" -> "x and y": addresses differ from run to run.
std::string without_addresses(std::string_view text) {
  std::string result(text);
  for (auto begin = result.find("(0x"); begin != std::string::npos; begin = result.find("(0x")) {
    const auto end = result.find(')', begin);
    if (begin > 0 && result[begin - 1] == ' ') --begin;
    result.erase(begin, end == std::string::npos ? end : end + 1 - begin);
  }
  return result;
}

// "ERROR: In x.cxx, line 7\nvtkReader (0x55): Message\n\n" and "Generic Warning: In x.cxx, line
// 7\nMessage\n\n" -> "Message"
std::string plain(std::string_view whole) {
  const std::string without = without_addresses(whole);
  std::string_view text = without;
  const auto line_end = text.find('\n');
  if (line_end != std::string_view::npos &&
      text.substr(0, line_end).find(", line ") != std::string_view::npos) {
    text.remove_prefix(line_end + 1);
  }
  const auto class_end = text.find(": ");
  if (text.starts_with("vtk") && class_end < text.find_first_of(" \n"))
    text.remove_prefix(class_end + 2);
  text = text.substr(0, text.find(" for request: vtkInformation"));
  std::string result;
  for (const char c : text) {
    const bool is_break = c == '\n' || c == '\r';
    if (!is_break)
      result += c;
    else if (!result.empty() && result.back() != ' ')
      result += ' ';
  }
  while (!result.empty() && (result.back() == ' ' || result.back() == '.')) result.pop_back();
  return result.substr(0, 300);
}

class CapturingWindow final : public vtkOutputWindow {
 public:
  static CapturingWindow* New();

  void DisplayErrorText(const char* text) override {
    if (is_mine())
      take(text, errors);
    else
      previous->DisplayErrorText(text);
  }
  void DisplayWarningText(const char* text) override {
    if (is_mine())
      take_warning(text);
    else
      previous->DisplayWarningText(text);
  }
  void DisplayGenericWarningText(const char* text) override {
    if (is_mine())
      take_warning(text);
    else
      previous->DisplayGenericWarningText(text);
  }
  void DisplayDebugText(const char* text) override {
    if (!is_mine()) previous->DisplayDebugText(text);
  }
  void DisplayText(const char* text) override {
    if (!is_mine()) previous->DisplayText(text);
  }

  vtkSmartPointer<vtkOutputWindow> previous;
  std::thread::id thread = std::this_thread::get_id();
  std::vector<std::string> errors;
  std::vector<std::string> warnings;

 private:
  bool is_mine() const { return std::this_thread::get_id() == thread; }

  // The legacy reader says "Error reading binary data!" as a warning and goes on with what memory
  // happens to hold.
  void take_warning(const char* text) {
    take(text, std::string_view(text).find("rror") != std::string_view::npos ? errors : warnings);
  }

  static void take(const char* text, std::vector<std::string>& into) {
    if (into.size() < kMaxMessages) into.push_back(plain(text));
  }
};

vtkStandardNewMacro(CapturingWindow);

std::mutex& window_mutex() {
  static std::mutex mutex;
  return mutex;
}

}  // namespace

struct VtkMessages::Impl {
  std::lock_guard<std::mutex> lock{window_mutex()};
  vtkSmartPointer<CapturingWindow> window = vtkSmartPointer<CapturingWindow>::New();
  vtkLogger::Verbosity verbosity = vtkLogger::GetCurrentVerbosityCutoff();
};

VtkMessages::VtkMessages() : impl_(std::make_unique<Impl>()) {
  impl_->window->previous = vtkOutputWindow::GetInstance();
  vtkOutputWindow::SetInstance(impl_->window);
  // The same messages go to VTK's log, which prints them on stderr.
  vtkLogger::SetStderrVerbosity(vtkLogger::VERBOSITY_OFF);
}

VtkMessages::~VtkMessages() {
  vtkLogger::SetStderrVerbosity(impl_->verbosity);
  vtkOutputWindow::SetInstance(impl_->window->previous);
}

const std::vector<std::string>& VtkMessages::errors() const noexcept {
  return impl_->window->errors;
}
const std::vector<std::string>& VtkMessages::warnings() const noexcept {
  return impl_->window->warnings;
}

}  // namespace ovoid::io

#endif
