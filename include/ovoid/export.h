// SPDX-License-Identifier: Apache-2.0
#pragma once

// Everything that a public header declares in a namespace marked so can be called from outside the
// library, and nothing else can: the rest is compiled with hidden visibility.
#define OVOID_API [[gnu::visibility("default")]]
