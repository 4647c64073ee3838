# SPDX-License-Identifier: Apache-2.0
# bash completion of ovoid. The program itself tells its commands and flags (`ovoid --list-flags`,
# `ovoid COMMAND --list-flags`: name, form of the value, sentence, with tabs between), so that this is never out of date.

_ovoid() {
  local word=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD - 1]} program=${COMP_WORDS[0]}
  local names form choices=
  COMPREPLY=()
  if ((COMP_CWORD == 1)); then
    compopt -o filenames 2>/dev/null
    mapfile -t COMPREPLY < <(compgen -W "$("$program" --list-flags 2>/dev/null | cut -f1)" -- "$word"; compgen -f -- "$word")
    return
  fi
  local command=${COMP_WORDS[1]}
  # A file in the command's place is for the viewer.
  "$program" --list-flags 2>/dev/null | cut -f1 | grep -qxF -e "$command" || command=view
  while IFS=$'\t' read -r names form _; do
    [[ ,$names, == *,"$before",* ]] || continue
    if [[ $form == *'|'* && $form != *[A-Z]* ]]; then choices=${form//|/ }; fi
    if [[ -n $form && $form != '['* && -z $choices && $form != *FILE* && $form != OUT ]]; then return; fi
  done < <("$program" "$command" --list-flags 2>/dev/null)
  if [[ -n $choices ]]; then
    mapfile -t COMPREPLY < <(compgen -W "$choices" -- "$word")
  elif [[ $word == -* ]]; then
    mapfile -t COMPREPLY < <(compgen -W "$("$program" "$command" --list-flags 2>/dev/null | cut -f1 | tr ',' '\n')" -- "$word")
  else
    compopt -o filenames 2>/dev/null
    mapfile -t COMPREPLY < <(compgen -f -- "$word")
  fi
}
complete -F _ovoid ovoid
