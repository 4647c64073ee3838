// SPDX-License-Identifier: Apache-2.0
// ovoid-read: reads files with other people's libraries, in a process of its own, for libovoid,
// which starts it. Of no use to people.
#include "io/foreign/foreign_readers.h"
#include "serve.h"

int main() { return ovoid::reader::run_reader("ovoid-read", ovoid::io::read_here); }
