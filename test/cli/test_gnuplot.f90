!> Figures by gnuplot: with it, without it, and when it fails. A shell script of a test's own stands
!> for gnuplot where the real one is not needed.
module test_gnuplot
    use, intrinsic :: iso_c_binding, only: c_associated, c_char, c_int, c_null_char, c_ptr, c_size_t
    use gracecg_base_kinds, only: dp
    use gracecg_base_error, only: error_t, message_of
    use gracecg_files_file, only: file_exists, make_directory, text_file_t, read_text_file
    use gracecg_cli_gnuplot
    use gracecg_cli_panels
    use testdrive, only: new_unittest, unittest_type, error_type, check, test_failed, skip_test
    use fixture, only: FOLDER, make_folder, make_file, check_passes, check_fails
    implicit none
    private
    public :: collect_gnuplot

    character(1), parameter :: LF = achar(10)

    interface
        function c_getcwd(buffer, length) bind(c, name='getcwd') result(path)
            import :: c_char, c_ptr, c_size_t
            character(kind=c_char), intent(out) :: buffer(*)
            integer(c_size_t), value :: length
            type(c_ptr) :: path
        end function c_getcwd

        integer(c_int) function c_setenv(name, value, overwrite) bind(c, name='setenv')
            import :: c_char, c_int
            character(kind=c_char), intent(in) :: name(*), value(*)
            integer(c_int), value :: overwrite
        end function c_setenv
    end interface

contains

    subroutine collect_gnuplot(testsuite)
        type(unittest_type), allocatable, intent(out) :: testsuite(:)

        testsuite = [ &
                    new_unittest('words-of-the-shell', test_quoting), &
                    new_unittest('data-block', test_data_block), &
                    new_unittest('without-gnuplot', test_without), &
                    new_unittest('gnuplot-fails', test_failing), &
                    new_unittest('gnuplot-draws', test_drawing), &
                    new_unittest('strange-folder', test_strange_folder), &
                    new_unittest('panels', test_panels)]
    end subroutine collect_gnuplot

    !> Runs a test with another PATH.
    subroutine set_path(path, old)
        character(*), intent(in) :: path
        character(:), allocatable, intent(out) :: old

        integer :: length
        integer(c_int) :: status

        call get_environment_variable('PATH', length=length)
        allocate (character(length) :: old)
        call get_environment_variable('PATH', old)
        status = c_setenv('PATH'//c_null_char, path//c_null_char, 1_c_int)
    end subroutine set_path

    !> A folder with a gnuplot of the given shell commands.
    subroutine fake_gnuplot(error, commands)
        type(error_type), allocatable, intent(out) :: error
        character(*), intent(in) :: commands

        type(error_t), allocatable :: failure

        call make_folder(error)
        if (allocated(error)) return
        call make_directory(FOLDER//'bin', failure)
        call check_passes(error, message_of(failure))
        if (.not. allocated(error)) call make_file(error, 'bin/gnuplot', '#!/bin/sh'//LF//commands//LF)
        if (.not. allocated(error)) call execute_command_line('chmod +x '//FOLDER//'bin/gnuplot')
    end subroutine fake_gnuplot

    subroutine test_quoting(error)
        type(error_type), allocatable, intent(out) :: error

        call check(error, shell_quoted('a b') == "'a b'")
        if (allocated(error)) return
        call check(error, shell_quoted('it''s $(x) `y` "z" \') == "'it'\''s $(x) `y` ""z"" \'")
        if (allocated(error)) return
        call check(error, shell_quoted('') == "''")
    end subroutine test_quoting

    subroutine test_data_block(error)
        type(error_type), allocatable, intent(out) :: error

        call check(error, data_block('d', reshape([1.0_dp, 0.1_dp, 2.0_dp, 1e-20_dp], [2, 2])) == &
                   '$d << end_of_data'//LF//'1,0.1'//LF//'2,1e-20'//LF//'end_of_data'//LF, &
                   data_block('d', reshape([1.0_dp, 0.1_dp, 2.0_dp, 1e-20_dp], [2, 2])))
    end subroutine test_data_block

    !> The script is there, the old figure is not, the reason is said.
    subroutine test_without(error)
        type(error_type), allocatable, intent(out) :: error
        character(:), allocatable :: svg, reason, old_path, ignored
        type(error_t), allocatable :: failure
        logical :: found

        call make_file(error, 'plot.svg', 'old')
        if (allocated(error)) return
        call set_path(FOLDER//'no-such-folder', old_path)
        found = gnuplot_found()
        call draw_figure(FOLDER, 'plot', script_head('plot', 'A test', 600, 300)//'plot x'//LF, svg, reason, failure)
        call set_path(old_path, ignored)
        call check_passes(error, message_of(failure))
        if (allocated(error)) return
        call check(error, .not. found .and. svg == '' .and. reason == NO_GNUPLOT)
        if (allocated(error)) return
        call check(error, file_exists(FOLDER//'plot.gp') .and. .not. file_exists(FOLDER//'plot.svg'))
    end subroutine test_without

    !> Status and messages of gnuplot are the reason; nothing half drawn stays.
    subroutine test_failing(error)
        type(error_type), allocatable, intent(out) :: error
        character(:), allocatable :: svg, reason, old_path, ignored
        type(error_t), allocatable :: failure

        call fake_gnuplot(error, 'echo "line 7: a mistake" >&2; echo half >plot.svg.part; exit 3')
        if (.not. allocated(error)) call make_file(error, 'plot.svg', 'old')
        if (allocated(error)) return
        call set_path(absolute(FOLDER//'bin')//':/usr/bin:/bin', old_path)
        call draw_figure(FOLDER, 'plot', 'plot x', svg, reason, failure)
        call set_path(old_path, ignored)
        call check_passes(error, message_of(failure))
        if (.not. allocated(error)) call check_fails(error, reason, [character(20) :: 'status', 'line 7: a mistake'])
        if (allocated(error)) return
        call check(error, svg == '' .and. .not. (file_exists(FOLDER//'plot.svg') .or. &
                                                 file_exists(FOLDER//'plot.svg.part') .or. &
                                                 file_exists(FOLDER//'plot.gp.log')))
        if (allocated(error)) return
        call fake_gnuplot(error, 'echo "<svg>" >plot.svg.part')
        if (allocated(error)) return
        call set_path(absolute(FOLDER//'bin')//':/usr/bin:/bin', old_path)
        call draw_figure(FOLDER, 'plot', 'plot x', svg, reason, failure)
        call set_path(old_path, ignored)
        call check_fails(error, reason, [character(20) :: 'no complete figure'])
        if (allocated(error)) return
        call check(error, svg == '' .and. .not. file_exists(FOLDER//'plot.svg'))
    end subroutine test_failing

    !> With the real gnuplot, where there is one.
    subroutine test_drawing(error)
        type(error_type), allocatable, intent(out) :: error
        character(:), allocatable :: svg, reason
        type(error_t), allocatable :: failure
        type(text_file_t) :: file

        call make_folder(error)
        if (allocated(error)) return
        if (.not. gnuplot_found()) then
            call skip_test(error, 'no gnuplot')
            return
        end if
        call draw_figure(FOLDER, 'plot', script_head('plot', 'A test', 600, 300)// &
                         'plot x with lines linetype 1'//LF, svg, reason, failure)
        if (.not. allocated(failure)) call read_text_file(FOLDER//'plot.svg', file, failure)
        call check_passes(error, message_of(failure))
        if (.not. allocated(error)) call check(error, reason == '', reason)
        if (.not. allocated(error)) call check(error, file%text == svg)
        if (.not. allocated(error)) call check(error, index(svg, 'viewBox="0 0 600 300"') > 0 .and. &
                                               index(svg, 'rgb(  0, 114, 178)') > 0, 'size and colour')
        if (allocated(error)) return
        call draw_figure(FOLDER, 'plot', 'plot nosuchfunction(x)'//LF, svg, reason, failure)
        call check_fails(error, reason, [character(40) :: 'status', 'undefined function'])
    end subroutine test_drawing

    !> Blanks, quotes, dollars, a leading minus: the folder is one word, and CDPATH is not asked.
    subroutine test_strange_folder(error)
        type(error_type), allocatable, intent(out) :: error
        character(*), parameter :: NAME = FOLDER//'-it''s $HOME; a "test"'
        character(:), allocatable :: svg, reason, old_path, ignored
        type(error_t), allocatable :: failure

        call fake_gnuplot(error, 'echo "<svg></svg>" >plot.svg.part')
        if (allocated(error)) return
        call make_directory(NAME, failure)
        call check_passes(error, message_of(failure))
        if (allocated(error)) return
        call set_path(absolute(FOLDER//'bin')//':/usr/bin:/bin', old_path)
        call draw_figure(NAME, 'plot', 'plot x', svg, reason, failure)
        call set_path(old_path, ignored)
        call check_passes(error, message_of(failure)//reason)
        if (allocated(error)) return
        call check(error, svg == '<svg></svg>'//LF .and. file_exists(NAME//'/plot.svg'))
    end subroutine test_strange_folder

    function absolute(path) result(full)
        character(*), intent(in) :: path
        character(:), allocatable :: full

        character(kind=c_char) :: here(4096)
        integer :: i

        if (.not. c_associated(c_getcwd(here, size(here, kind=c_size_t)))) error stop 'no working folder'
        full = ''
        do i = 1, size(here)
            if (here(i) == c_null_char) exit
            full = full//here(i)
        end do
        full = full//'/'//path
    end function absolute

    !> A grid's script: panels in their order, the printed limits, tics that are few, marks, and a legend.
    subroutine test_panels(error)
        type(error_type), allocatable, intent(out) :: error
        character(40), parameter :: PARTS(10) = [character(40) :: &
            'set multiplot layout 2,2', 'set title "third"', 'set yrange [-1.7', 'set ytics 1.00E+01', &
            'graph 0, first -1 to graph 1, first 2', 'set label "case 2" at 3', 'set format x ""', &
            'set xlabel "run"', 'pointtype 4', 'linecolor rgb ink']
        type(panel_t) :: panels(3)
        type(legend_item_t) :: legend(2)
        type(grid_t) :: grid
        character(:), allocatable :: script
        integer :: i

        grid%columns = 2
        grid%x_label = 'run'
        panels%title = [character(10) :: 'first', 'second', 'third']
        panels%plot = 'x'
        panels(2)%has_limits = .true.
        panels(2)%low = -1
        panels(2)%high = 2
        panels(2)%least = 0
        panels(2)%greatest = 9
        panels(3)%least = 0
        panels(3)%greatest = 40
        legend(1) = legend_item_t('points', 2, 4)
        legend(2) = legend_item_t('truth')
        script = panel_grid('plot', 'a test', grid, panels, legend, [1.0_dp, 3.0_dp], 'case')
        do i = 1, size(PARTS)
            call check(error, index(script, trim(PARTS(i))) > 0, trim(PARTS(i))//' is not in '//script)
            if (allocated(error)) return
        end do
        call check(error, index(script, '"first"') < index(script, '"second"') .and. &
                   index(script, '"second"') < index(script, '"third"'))
    end subroutine test_panels
end module test_gnuplot
