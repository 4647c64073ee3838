// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace ovoid::io {

// JPEG, JPEG-LS and JPEG 2000 in DICOM are decoded by GDCM in this process from now on. Without
// GDCM (OVOID_IO_GDCM off) nothing changes.
void use_gdcm() noexcept;

}  // namespace ovoid::io
