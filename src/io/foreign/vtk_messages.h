// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>
#include <vector>

namespace ovoid::io {

// While it lives, what VTK says on this thread is collected and not printed; other threads'
// messages go where they went before. One at a time per process: a second one waits. Only with VTK
// (OVOID_IO_VTK).
class VtkMessages {
 public:
  VtkMessages();
  ~VtkMessages();
  VtkMessages(const VtkMessages&) = delete;
  VtkMessages& operator=(const VtkMessages&) = delete;

  // One line each, without VTK's "ERROR: In file, line" and object addresses. A warning that
  // reports an error counts as one.
  const std::vector<std::string>& errors() const noexcept;
  const std::vector<std::string>& warnings() const noexcept;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace ovoid::io
