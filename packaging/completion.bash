# Completion of gracecg for bash: commands and options, as its help lists them; all else are files.
_gracecg()
{
    local program=${COMP_WORDS[0]} current=${COMP_WORDS[COMP_CWORD]} words=("${COMP_WORDS[@]:1:COMP_CWORD-1}") group
    [[ ${words[0]} == help ]] && words=("${words[@]:1}")
    case ${words[*]} in
        '') group= ;;
        model | level1) group="${words[0]} " ;;
        *)
            [[ $current == -* ]] || return
            mapfile -t COMPREPLY < <(compgen -W "$("$program" "${words[@]}" --help 2> /dev/null |
                sed -n 's/^  \(--[a-z0-9-]*\).*/\1/p')" -- "$current")
            return ;;
    esac
    mapfile -t COMPREPLY < <(compgen -W "$("$program" --help | sed -n "s/^  $group\([a-z0-9-]*\).*  .*/\1/p" | sort -u) help" \
        -- "$current")
}
complete -o default -F _gracecg gracecg
