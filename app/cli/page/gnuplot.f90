!> Figures by gnuplot: writes a script, runs gnuplot where it is installed, and returns the SVG.
!>
!> A script stands beside its data files and names them without a folder, so that
!> `gnuplot NAME.gp` in that folder draws the figure again.
module gracecg_cli_gnuplot
    use gracecg_base_kinds, only: dp
    use gracecg_base_error, only: error_t
    use gracecg_base_text, only: integer_text, real_text
    use gracecg_files_file, only: output_file_t, text_file_t, read_text_file, remove_file, file_exists
    use gracecg_cli_palette, only: PALETTE
    implicit none
    private
    public :: gnuplot_found, script_head, data_block, draw_figure, shell_quoted, NO_GNUPLOT

    character(*), parameter :: NO_GNUPLOT = &
        'gnuplot was not found; install it (Debian: apt-get install gnuplot-nox)'
    !! Said where figures are missing
    character(1), parameter :: LF = achar(10)
    character(*), parameter :: SCRIPT_END = '.gp', FIGURE_END = '.svg', PART_END = '.svg.part', LOG_END = '.gp.log'

contains

    !> Whether there is a gnuplot on the PATH.
    logical function gnuplot_found()
        integer :: status, command_status

        status = 1
        call execute_command_line('command -v gnuplot >/dev/null 2>&1', exitstat=status, cmdstat=command_status)
        gnuplot_found = command_status == 0 .and. status == 0
    end function gnuplot_found

    !> The beginning of every script: size and output, CSV input, quiet axes, and the palette as line types
    !> 1 to 4 (blue, orange, green, purple), 5 (grey, for printed limits) and the colour names `grey`, `band`, `ink`.
    function script_head(name, contents, width, height) result(script)
        character(*), intent(in) :: name        !! Of the figure: the name of its files
        character(*), intent(in) :: contents    !! What the figure shows, for a comment
        integer, intent(in) :: width, height    !! Of the drawing; 16 units are a letter's height
        character(:), allocatable :: script

        integer :: i

        script = '# '//contents//LF//'# Draws '//name//FIGURE_END//': gnuplot '//name//SCRIPT_END//LF//LF// &
                 'set encoding utf8'//LF// &
                 'if (!exists("output")) output = "'//name//FIGURE_END//'"'//LF// &
                 'set terminal svg size '//integer_text(width)//','//integer_text(height)// &
                 ' dynamic enhanced font "sans-serif,16" background "white" name "'//name//'"'//LF// &
                 'set output output'//LF// &
                 'set datafile separator ","'//LF// &
                 'set datafile commentschars "#"'//LF
        do i = 1, size(PALETTE)
            script = script//trim(PALETTE(i)%name)//' = "'//PALETTE(i)%light//'"'//LF
            if (i <= 5) script = script//'set linetype '//integer_text(i)//' linecolor rgb '// &
                                 trim(PALETTE(i)%name)//' linewidth '//trim(merge('1.5', '2  ', i == 5))// &
                                 trim(merge(' dashtype 2', '           ', i == 5))//LF
        end do
        script = script//'set border 3 linecolor rgb grey linewidth 1'//LF// &
                 'set tics nomirror out scale 0.6'//LF// &
                 'set grid ytics linetype 1 linecolor "gray" linewidth 0.5'//LF// &
                 'set xtics offset 0,0.4'//LF//'set xlabel offset 0,0.9'//LF//LF
    end function script_head

    !> Numbers as a data block `$name` of a script, with commas, a row for every second index.
    function data_block(name, values) result(script)
        character(*), intent(in) :: name    !! Of the block in the script, without $
        real(dp), intent(in) :: values(:, :)    !! (column, row)
        character(:), allocatable :: script

        integer :: i, k

        script = '$'//name//' << end_of_data'//LF
        do k = 1, size(values, 2)
            do i = 1, size(values, 1)
                if (i > 1) script = script//','
                script = script//real_text(values(i, k))
            end do
            script = script//LF
        end do
        script = script//'end_of_data'//LF
    end function data_block

    !> Writes DIR/NAME.gp and draws DIR/NAME.svg with it.
    !>
    !> Where gnuplot is missing or cannot draw the figure, `svg` is empty and `reason` says why; the script is
    !> there all the same. An older figure of that name is removed then: it would not belong to the data.
    !> Fails when a file cannot be written.
    subroutine draw_figure(folder, name, script, svg, reason, error)
        character(*), intent(in) :: folder              !! Exists; the script's data files are there
        character(*), intent(in) :: name                !! Letters, digits, underscores
        character(*), intent(in) :: script              !! Begins with script_head
        character(:), allocatable, intent(out) :: svg    !! The figure
        character(:), allocatable, intent(out) :: reason        !! Empty when the figure is drawn
        type(error_t), allocatable, intent(out) :: error

        character(:), allocatable :: path

        svg = ''
        reason = ''
        path = folder//'/'//name
        call write_text(path//SCRIPT_END, script, error)
        if (allocated(error)) return
        if (gnuplot_found()) then
            call run_gnuplot(folder, name, svg, reason)
        else
            reason = NO_GNUPLOT
        end if
        if (reason == '') then
            svg = without_last_line_end(svg)//LF
            call write_text(path//FIGURE_END, svg, error)
        else
            call remove_file(path//FIGURE_END)
        end if
    end subroutine draw_figure

    !> Runs gnuplot in the folder. It writes under a temporary name, and its messages into a file, which
    !> are gone afterwards.
    subroutine run_gnuplot(folder, name, svg, reason)
        character(*), intent(in) :: folder, name
        character(:), allocatable, intent(out) :: svg, reason

        character(:), allocatable :: path, messages
        integer :: status, command_status

        path = folder//'/'//name
        call remove_file(path//PART_END)
        status = 0
        call execute_command_line('cd '//shell_quoted(from_here(folder))//' && gnuplot -d -e '// &
                                  shell_quoted('output = "'//name//PART_END//'"')//' '//name//SCRIPT_END// &
                                  ' </dev/null >'//name//LOG_END//' 2>&1', &
                                  exitstat=status, cmdstat=command_status)
        svg = content_of(path//PART_END)
        messages = content_of(path//LOG_END)
        call remove_file(path//PART_END)
        call remove_file(path//LOG_END)
        reason = ''
        if (status /= 0) then       ! first: flang sets command_status too where a command ends with another status than 0
            reason = 'gnuplot ended with status '//integer_text(status)//': '//on_one_line(messages)
        else if (command_status /= 0) then
            reason = 'the shell could not run gnuplot'
        else if (index(svg, '</svg>') == 0) then
            reason = 'gnuplot wrote no complete figure: '//on_one_line(messages)
        end if
        if (reason /= '') svg = ''
    end subroutine run_gnuplot

    !> A path that the shell's cd takes for one: not - or an option, and not searched for in CDPATH.
    pure function from_here(folder) result(path)
        character(*), intent(in) :: folder
        character(:), allocatable :: path

        path = folder
        if (index(folder, '/') /= 1) path = './'//folder
    end function from_here

    !> A text as one word of the shell, whatever is in it.
    pure function shell_quoted(text) result(word)
        character(*), intent(in) :: text    !! Any
        character(:), allocatable :: word

        integer :: i

        word = "'"
        do i = 1, len(text)
            if (text(i:i) == "'") then
                word = word//"'\''"
            else
                word = word//text(i:i)
            end if
        end do
        word = word//"'"
    end function shell_quoted

    subroutine write_text(path, text, error)
        character(*), intent(in) :: path, text
        type(error_t), allocatable, intent(out) :: error

        type(output_file_t) :: file

        call file%open(path, error)
        if (allocated(error)) return
        call file%line(without_last_line_end(text))
        call file%commit(error)
    end subroutine write_text

    pure function without_last_line_end(text) result(shorter)
        character(*), intent(in) :: text
        character(:), allocatable :: shorter

        shorter = text(:verify(text, LF, back=.true.))
    end function without_last_line_end

    !> The whole of a file; empty where it cannot be read.
    function content_of(path) result(text)
        character(*), intent(in) :: path
        character(:), allocatable :: text

        type(text_file_t) :: file
        type(error_t), allocatable :: error

        text = ''
        if (.not. file_exists(path)) return
        call read_text_file(path, file, error)
        if (.not. allocated(error)) text = file%text
    end function content_of

    pure function on_one_line(text) result(line)
        character(*), intent(in) :: text
        character(:), allocatable :: line

        integer :: i

        line = ''
        do i = 1, len_trim(text)
            if (text(i:i) /= LF) then
                line = line//text(i:i)
            else if (line /= '') then
                if (line(len(line):) /= ' ') line = line//' '
            end if
        end do
        if (line == '') line = '(no message)'
    end function on_one_line
end module gracecg_cli_gnuplot
