# SPDX-License-Identifier: Apache-2.0
# For the scripts that measure. An idle virtual processor wakes up late and slowly. A spinner
# on each keeps it awake; at idle priority it yields to the benchmark immediately.

spinners=()

stop_spinners() {
  if ((${#spinners[@]})); then
    kill "${spinners[@]}" 2>/dev/null || true
  fi
  spinners=()
}

keep_awake() {
  trap stop_spinners EXIT
  if command -v chrt >/dev/null && chrt -i 0 true 2>/dev/null; then
    for ((i = 0; i < $(nproc); ++i)); do
      chrt -i 0 sh -c 'while :; do :; done' &
      spinners+=($!)
    done
  fi
}
