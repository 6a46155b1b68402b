# Completion of knap in bash: commands and options as the program's own help lists them, files elsewhere.
# shellcheck shell=bash

_knap_words() {
  # Names at the beginning of a line of the help, such as "  learn   Learns…" and "  --seed UINT  …".
  "$@" --help 2>/dev/null | sed -n 's/^  \([a-z][a-z-]*\) .*/\1/p; s/^  \(-[a-z],\)\{0,1\}\(--[a-z-]*\).*/\2/p'
}

_knap() {
  local word=${COMP_WORDS[COMP_CWORD]}
  COMPREPLY=()
  if ((COMP_CWORD == 1)); then
    mapfile -t COMPREPLY < <(compgen -W "$(_knap_words "${COMP_WORDS[0]}")" -- "$word")
  elif [[ $word == -* ]]; then
    mapfile -t COMPREPLY < <(compgen -W "$(_knap_words "${COMP_WORDS[0]}" "${COMP_WORDS[1]}")" -- "$word")
  fi
}

complete -o default -F _knap knap
