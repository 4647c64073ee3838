// SPDX-License-Identifier: Apache-2.0
// ovoid-read: reads files with other people's libraries, in a process of its own, for libovoid,
// which starts it. Of no use to people.
#include <sys/socket.h>
#include <unistd.h>

#include <cstdio>

#include "serve.h"

int main() {
  constexpr int kSocket = 3;
  int type = 0;
  socklen_t size = sizeof(type);
  if (::getsockopt(kSocket, SOL_SOCKET, SO_TYPE, &type, &size) != 0) {
    std::fputs("ovoid-read: is started by Ovoid's library and has no use of its own\n", stderr);
    return 2;
  }
  ovoid::reader::serve_requests(ovoid::io::UniqueFd(kSocket));
}
