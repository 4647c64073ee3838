#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Runs a shard of a test program, unless the time (seconds since 1970) in OVOID_LAST_START is over, after which CI begins nothing
# more: shard.sh PROGRAM. Exit code 77: it was left out.
if [[ -n ${OVOID_LAST_START:-} ]] && (($(date +%s) > OVOID_LAST_START)); then
  echo "left out, for want of time"
  exit 77
fi
exec "$1"
