# SPDX-License-Identifier: Apache-2.0

_touchable_files() {  # -f or -d
    compopt -o filenames 2>/dev/null
    mapfile -t COMPREPLY < <(compgen "$1" -- "$2")
}

_touchable_offer() {  # words; what more is to be typed behind : or = follows without a space
    local word
    for word in $1; do
        [[ $word == "$2"* ]] && COMPREPLY+=("$word")
    done
    [[ ${#COMPREPLY[@]} != 1 || $COMPREPLY != *[:=] ]] || compopt -o nospace 2>/dev/null
}

_touchable() {
    local current=${COMP_WORDS[COMP_CWORD]} before='' command=${COMP_WORDS[1]} value
    COMPREPLY=()
    ((COMP_CWORD == 0)) || before=${COMP_WORDS[COMP_CWORD - 1]}
    # Bash parts --option=value at the sign.
    if [[ $current == = ]]; then current=''
    elif [[ $before == = ]]; then before=${COMP_WORDS[COMP_CWORD - 2]}
    fi
    if ((COMP_CWORD == 1)); then
        if [[ $current == -* ]]; then
            mapfile -t COMPREPLY < <(compgen -W '-h --help --help-all -V --version' -- "$current")
        else  # a clip in place of a command is played
            compopt -o filenames 2>/dev/null
            mapfile -t COMPREPLY < <(compgen -W "$_touchable_commands" -- "$current"; compgen -f -- "$current")
        fi
        return
    fi
    if [[ $command == help ]]; then
        case $COMP_CWORD in
            2) mapfile -t COMPREPLY < <(compgen -W "${_touchable_commands% help}" -- "$current") ;;
            3) mapfile -t COMPREPLY < <(compgen -W "${_touchable_topics[$before]:-}" -- "$current") ;;
        esac
        return
    fi
    if ((COMP_CWORD == 3)) && [[ $before == -h || $before == --help ]]; then
        mapfile -t COMPREPLY < <(compgen -W "${_touchable_topics[$command]:-}" -- "$current")
        return
    fi
    [[ -n ${_touchable_options[$command]:-} ]] || command=play
    value=${_touchable_values[$command $before]:-}
    case $value in
        FILE) _touchable_files -f "$current" ;;
        FOLDER) _touchable_files -d "$current" ;;
        {*})
            _touchable_offer "${value//[\{\}]/}" "$current" ;;
        anything) ;;
        *)
            if [[ $current == -* ]]; then
                mapfile -t COMPREPLY < <(compgen -W "${_touchable_options[$command]}" -- "$current")
            elif ((COMP_CWORD == 2)) && [[ -n ${_touchable_words[$command]:-} ]]; then
                mapfile -t COMPREPLY < <(compgen -W "${_touchable_words[$command]}" -- "$current")
            else
                _touchable_files -f "$current"
            fi ;;
    esac
} && complete -F _touchable touchable
