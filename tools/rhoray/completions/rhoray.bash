# Completion of rhoray for bash: `rhoray complete` knows what may follow.
_rhoray() {
  local line word=${COMP_WORDS[COMP_CWORD]} paths=
  # bash takes "--option=value" for three words.
  local -a words=()
  local i
  for ((i = 1; i <= COMP_CWORD; ++i)); do
    if [[ ${COMP_WORDS[i]} == "=" && ${#words[@]} -gt 0 ]]; then
      words[-1]+="="
    elif [[ $i -gt 1 && ${COMP_WORDS[i-1]} == "=" && ${#words[@]} -gt 0 ]]; then
      words[-1]+=${COMP_WORDS[i]}
    else
      words+=("${COMP_WORDS[i]}")
    fi
  done
  [[ $word == "=" ]] && word=
  COMPREPLY=()
  while IFS= read -r line; do
    case $line in
      :files | :folders) paths=$line ;;
      *) COMPREPLY+=("$(printf %q "${line%%$'\t'*}")") ;;
    esac
  done < <("${COMP_WORDS[0]}" complete "${words[@]}" 2>/dev/null)
  if [[ $paths == :files ]]; then
    compopt -o filenames
    mapfile -t -O ${#COMPREPLY[@]} COMPREPLY < <(compgen -f -- "$word")
  elif [[ $paths == :folders ]]; then
    compopt -o filenames
    mapfile -t -O ${#COMPREPLY[@]} COMPREPLY < <(compgen -d -- "$word")
  fi
}
complete -F _rhoray rhoray
