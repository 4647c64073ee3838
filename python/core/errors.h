// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace ovoid::python {

// From now on the library's and the program's exceptions are those of the Python module
// ovoid._errors, with the same words.
void translate_errors();

}  // namespace ovoid::python
