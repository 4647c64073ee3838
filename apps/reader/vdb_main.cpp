// SPDX-License-Identifier: Apache-2.0
// ovoid-read-vdb: what ovoid-read is, for OpenVDB files.
#include "io/foreign/vdb.h"
#include "serve.h"

int main() { return ovoid::reader::run_reader("ovoid-read-vdb", ovoid::io::read_vdb_here); }
