// SPDX-License-Identifier: Apache-2.0
#ifdef OVOID_IO_VTK

#include "io/vtk_messages.h"

#include <vtkLogger.h>
#include <vtkObjectFactory.h>
#include <vtkOutputWindow.h>
#include <vtkSmartPointer.h>

#include <mutex>
#include <string_view>
#include <thread>

namespace ovoid::io {
namespace {

// "ERROR: In x.cxx, line 7\nvtkReader (0x55): Message\n\n" -> "Message"
std::string plain(std::string_view text) {
  const auto object_end = text.find("): ");
  if (object_end != std::string_view::npos) text.remove_prefix(object_end + 3);
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
      errors.push_back(plain(text));
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
    std::string message = plain(text);
    const bool is_error = message.find("rror") != std::string::npos;
    (is_error ? errors : warnings).push_back(std::move(message));
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
