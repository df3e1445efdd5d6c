!> gracecg report: everything that CSR-TM-00-01 shows, as one HTML page.
!>
!> Each chapter is a module gracecg_report_chapter_*: it computes, writes its CSV files, adds text,
!> tables and figures to the book, and notes what it found for the summary.
module gracecg_cli_report
    use, intrinsic :: iso_fortran_env, only: compiler_version
    use gracecg_base_kinds, only: dp
    use gracecg_base_constants, only: DEGREE, MILLIMETRE
    use gracecg_base_error, only: error_t, fail
    use gracecg_base_version, only: VERSION
    use gracecg_base_text, only: integer_text
    use gracecg_files_file, only: make_directory, check_writable
    use gracecg_cli_html, only: html_page_t, html_escaped, VERDICT_MET, VERDICT_PARTLY, VERDICT_MISSED
    use gracecg_environment_time, only: utc_text
    use gracecg_simulation_case, only: case_t
    use gracecg_planning_calibration, only: calibration_t, find_calibration, calibration_text
    use gracecg_simulation_report_cases, only: report_case, REPORT_CASE_NAMES, TIME_OF_CASE
    use gracecg_cli_campaign_tables, only: REPORT_RUNS
    use gracecg_cli_cases, only: case_place, rods_text
    use gracecg_cli_book, only: report_book_t, open_book, COMMAND
    use gracecg_cli_number_text, only: fixed_text, share_text
    use gracecg_cli_chapter_budget, only: add_budget_chapter
    use gracecg_cli_chapter_gradient, only: add_gradient_chapter
    use gracecg_cli_chapter_curves, only: add_curves_chapter
    use gracecg_cli_chapter_orbit, only: orbit_study_t, study_orbits, add_field_chapter, add_timing_chapter
    use gracecg_cli_chapter_accuracy, only: add_accuracy_chapter
    use gracecg_cli_chapter_sources, only: add_sources_chapter
    use gracecg_cli_chapter_loss, only: add_loss_chapter
    use gracecg_cli_chapter_limit, only: add_limit_chapter
    use gracecg_cli_chapter_design, only: add_design_chapter
    use gracecg_cli_arguments, only: arguments_t, MOST_RUNS
    use gracecg_cli_console, only: console_t
    implicit none
    private
    public :: declare_report, run_report

    character(*), parameter :: PAGE_NAME = 'index.html'
    integer, parameter :: DEFAULT_RUNS = 200

contains

    !> Says what the command takes.
    subroutine declare_report(arguments)
        type(arguments_t), intent(inout) :: arguments

        call arguments%describe(COMMAND, '', 0, 0, &
                                'Runs everything that CSR-TM-00-01 shows - Tables 1.1, 1.2, 6.1 and '// &
                                '6.2, Figures 3.1, 5.2 to 5.8 and 6.1 to 6.6 - and writes one HTML '// &
                                'page, '//PAGE_NAME//', with each beside the published numbers, a CSV '// &
                                'file for every figure, and the figures as SVG with the gnuplot scripts '// &
                                'that draw them; then, beyond the report, every estimator against the '// &
                                'theoretical limit, and a designed manoeuvre. '// &
                                'Without gnuplot the page has its tables, and says what '// &
                                'is missing.', &
                                'gracecg report --out report --runs 30')
        call arguments%add_option('--out', 'DIR', 'folder for '//PAGE_NAME//' and the other files; made '// &
                                  'if it is not there', &
                                  required=.true.)
        call arguments%add_option('--runs', 'N', 'of every Monte Carlo (default '// &
                                  integer_text(DEFAULT_RUNS)//', at least '// &
                                  integer_text(REPORT_RUNS)//', which the report has)')
        call arguments%add_option('--seed', 'S', 'of the random numbers (default 1)')
        call arguments%add_option('--threads', 'N', 'to work on (default: the processors of the '// &
                                  'machine); the numbers do not depend on it')
    end subroutine declare_report

    !> Computes the chapters and writes the page.
    subroutine run_report(arguments, console, misuse, error)
        type(arguments_t), intent(in) :: arguments
        type(console_t), intent(inout) :: console
        type(error_t), allocatable, intent(out) :: misuse, error

        type(report_book_t) :: book
        type(html_page_t) :: page
        character(:), allocatable :: folder
        integer :: runs, seed, threads

        call arguments%get('--out', folder, misuse)
        call arguments%get('--runs', runs, misuse, default=DEFAULT_RUNS, low=REPORT_RUNS, high=MOST_RUNS)
        call arguments%get('--seed', seed, misuse, default=1)
        call arguments%get_threads(threads, misuse)
        if (allocated(misuse)) return
        call make_directory(folder, error)
        if (.not. allocated(error)) call check_writable(folder//'/'//PAGE_NAME, error)
        if (allocated(error)) return

        call open_book(book, folder, runs, seed, threads)
        call add_chapters(book, console, error)
        if (allocated(error)) return
        call page%begin('GRACE CG offset determination by magnetic torquers: CSR-TM-00-01 recomputed', &
                        'The centre-of-gravity calibration of the GRACE satellites, as F. Wang''s '// &
                        'report CSR-TM-00-01 (The University of Texas at Austin, January 2000) '// &
                        'simulates it, computed anew by gracecg '//VERSION// &
                        ': every table and figure of results beside the published numbers, or beside '// &
                        'the printed axes where the curves are lost.')
        call add_summary(page, book)
        call page%append(book%page)
        call add_making(page, book)
        call page%write(folder//'/'//PAGE_NAME, error)
        if (allocated(error)) return
        call show(book, console, error)
    end subroutine run_report

    !> The chapters between summary and settings, in the order of the report.
    subroutine add_chapters(book, console, error)
        type(report_book_t), intent(inout) :: book
        type(console_t), intent(inout) :: console
        type(error_t), allocatable, intent(out) :: error

        type(orbit_study_t) :: orbits(2)

        call add_simulation(book, error)
        if (allocated(error)) return
        call add_budget_chapter(book)
        call study_orbits(book, console, orbits, error)
        if (.not. allocated(error)) call add_gradient_chapter(book, orbits(1)%orbit, error)
        if (.not. allocated(error)) call add_curves_chapter(book, console, error)
        if (.not. allocated(error)) call add_field_chapter(book, orbits, error)
        if (.not. allocated(error)) call add_accuracy_chapter(book, console, error)
        if (.not. allocated(error)) call add_timing_chapter(book, orbits, error)
        if (.not. allocated(error)) call add_sources_chapter(book, console, error)
        if (.not. allocated(error)) call add_loss_chapter(book, console, error)
        if (.not. allocated(error)) call add_limit_chapter(book, console, error)
        if (.not. allocated(error)) call add_design_chapter(book, console, error)
    end subroutine add_chapters

    !> What was found, a line for each figure and table.
    subroutine add_summary(page, book)
        type(html_page_t), intent(inout) :: page
        type(report_book_t), intent(in) :: book

        integer :: i

        call page%chapter('summary', 'Summary')
        call page%paragraph('Each line leads to its table or figure. Verdicts: '//share_text( &
                            count(book%findings%kind == VERDICT_MET), size(book%findings))//' agree '// &
                            'without a remark, '// &
                            integer_text(count(book%findings%kind == VERDICT_PARTLY))//' with one, '// &
                            integer_text(count(book%findings%kind == VERDICT_MISSED))//' differ.')
        if (book%not_drawn > 0) then
            call page%verdict(VERDICT_PARTLY, integer_text(book%not_drawn)//' figures are '// &
                              'missing.', book%reason)
        end if
        call page%begin_table('What the report shows, and what is found here', 'findings', stacks=.true.)
        call page%begin_row()
        call page%column_head('report')
        call page%column_head('verdict')
        call page%column_head('the report shows')
        call page%column_head('found here')
        call page%end_row()
        call page%head_end()
        do i = 1, size(book%findings)
            associate (found => book%findings(i))
                call page%begin_row()
                call page%row_head(trim(found%source), anchor=trim(found%anchor))
                call page%verdict_cell(found%kind, trim(found%verdict))
                call page%text_cell(trim(found%claim), wraps=.true.)
                call page%text_cell(trim(found%result), wraps=.true.)
                call page%end_row()
            end associate
        end do
        call page%end_table()
    end subroutine add_summary

    !> What was simulated: the idea, the six cases and their settings.
    subroutine add_simulation(book, error)
        type(report_book_t), intent(inout) :: book
        type(error_t), allocatable, intent(out) :: error

        type(calibration_t) :: calibration
        type(case_t) :: case
        character(:), allocatable :: text
        real(dp) :: latitude, longitude, height
        integer :: i, axis

        associate (page => book%page)
            call page%chapter('simulation', 'What is simulated')
            call page%paragraph('Two satellites fly behind each other at 460 km in a polar orbit, the '// &
                                'back one turned to face the front one. For a calibration the torque '// &
                                'rods of one satellite swing for 60 s at 0.1 Hz with 30 A m^{2} on two '// &
                                'axes and shake it against the geomagnetic field. Where the proof mass '// &
                                'of the accelerometer is off the centre of mass by d, the accelerometer '// &
                                'feels the angular acceleration times d; from its samples, from two '// &
                                'star cameras and from the magnetometer, d is estimated.')
            call page%paragraph('Truth: orbit and attitude by an RKF7(8) integration with EGM96 to '// &
                                'degree and order 20, IGRF-95, DTM-77 with a short-period density wave, '// &
                                'radiation of Sun and Earth, and all torques. Accelerometer at 10 Hz '// &
                                'with the coloured noise of (3-2), scale factors and bias; star cameras '// &
                                'at 2 Hz, attitude by QUEST from catalogued stars; magnetometer at 1 Hz '// &
                                'with noise and bias. The estimators see the samples and what an '// &
                                'operator knows, never the truth.')
            call page%begin_table('The six cases', 'cases')
            call page%begin_row()
            call page%column_head('case')
            call page%column_head('epoch (UTC)')
            call page%column_head('orbit, s', numeric=.true.)
            call page%column_head('latitude', numeric=.true.)
            call page%column_head('longitude', numeric=.true.)
            call page%column_head('height, km', numeric=.true.)
            call page%column_head('rods x, y, z, A m^{2}')
            call page%column_head('true offset x, y, z, mm', columns=3)
            call page%end_row()
            call page%head_end()
            do i = 1, size(REPORT_CASE_NAMES)
                call report_case(REPORT_CASE_NAMES(i), case, error)
                if (.not. allocated(error)) call case_place(case, latitude, longitude, height, error)
                if (allocated(error)) return
                call page%begin_row()
                call page%row_head(trim(case%name))
                call page%text_cell(trim(utc_text(case%epoch)))
                call page%number_cell(fixed_text(TIME_OF_CASE(case%number), 0))
                call page%number_cell(fixed_text(abs(latitude)/DEGREE, 1)//merge(' N', ' S', latitude >= 0))
                call page%number_cell(fixed_text(abs(longitude)/DEGREE, 1)//merge(' E', ' W', longitude >= 0))
                call page%number_cell(fixed_text(height/1000, 0))
                call page%text_cell(without_unit(rods_text(case%satellite%rods)))
                do axis = 1, 3
                    call page%number_cell(fixed_text(case%satellite%offset(axis)/MILLIMETRE, 1))
                end do
                call page%end_row()
            end do
            call page%end_table()
            call page%paragraph('Every setting of a case, with unit and meaning, as `gracecg cases show '// &
                                'CASE` prints it:')
            do i = 1, size(REPORT_CASE_NAMES)
                call find_calibration(REPORT_CASE_NAMES(i), calibration, error)
                if (.not. allocated(error)) call calibration_text(calibration, text, error)
                if (allocated(error)) return
                call page%details(trim(REPORT_CASE_NAMES(i)), text)
            end do
        end associate
    end subroutine add_simulation

    !> The rods' amplitudes without the unit, which stands in the head.
    pure function without_unit(text) result(numbers)
        character(*), intent(in) :: text
        character(:), allocatable :: numbers

        integer :: last

        last = index(text, ' A m^2')
        if (last == 0) last = len(text) + 1
        numbers = text(:last - 1)
    end function without_unit

    !> Settings, versions, files.
    subroutine add_making(page, book)
        type(html_page_t), intent(inout) :: page
        type(report_book_t), intent(in) :: book

        integer :: i

        call page%chapter('making', 'How this page was made')
        call page%begin_table('Settings and versions', 'settings')
        call page%begin_row()
        call page%column_head('setting')
        call page%column_head('value')
        call page%end_row()
        call page%head_end()
        call add_setting(page, 'command', 'gracecg report --runs '//integer_text(book%runs)//' --seed '// &
                         integer_text(book%seed))
        call add_setting(page, 'runs of every Monte Carlo', integer_text(book%runs))
        call add_setting(page, 'seed of the random numbers', integer_text(book%seed))
        call add_setting(page, 'gracecg', VERSION)
        call add_setting(page, 'compiler', compiler_version())
        if (book%renderer /= '') then
            call add_setting(page, 'figures', book%renderer)
        else
            call add_setting(page, 'figures', 'none drawn: '//book%reason)
        end if
        call page%end_table()
        call page%paragraph('The same command gives the same numbers on every machine and with any '// &
                            'number of threads. The numbers of the figures stand beside this page as '// &
                            'CSV, and with each figure the script that drew it: change it and run '// &
                            '`gnuplot NAME.gp` in its folder.')
        call page%markup('<ul class="files">')
        do i = 1, size(book%files)
            call add_link(page, book%files(i)%text)
        end do
        do i = 1, size(book%figures)
            call add_link(page, book%figures(i)%text//'.gp')
        end do
        call page%markup('</ul>')
    end subroutine add_making

    subroutine add_setting(page, name, value)
        type(html_page_t), intent(inout) :: page
        character(*), intent(in) :: name, value

        call page%begin_row()
        call page%row_head(name)
        call page%text_cell(value, wraps=.true.)
        call page%end_row()
    end subroutine add_setting

    subroutine add_link(page, name)
        type(html_page_t), intent(inout) :: page
        character(*), intent(in) :: name

        call page%markup('<li><a href="'//html_escaped(name)//'">'//html_escaped(name)//'</a></li>')
    end subroutine add_link

    !> What was found and written. Fails when gnuplot is there but could not draw a figure; the page is written all
    !> the same.
    subroutine show(book, console, error)
        type(report_book_t), intent(in) :: book
        type(console_t), intent(inout) :: console
        type(error_t), allocatable, intent(out) :: error

        integer :: i

        do i = 1, size(book%findings)
            associate (found => book%findings(i))
                call console%line(found%source//trim(found%verdict)//': '//trim(without_marks(trim(found%result))))
            end associate
        end do
        call console%line('')
        call console%line('written to '// &
                          book%folder//': '//PAGE_NAME//', '//integer_text(size(book%files))// &
                          ' data files, '//integer_text(size(book%figures))//' figure scripts, '// &
                          integer_text(size(book%figures) - book%not_drawn)//' figures')
        if (book%not_drawn == 0) return
        if (book%gnuplot_missing) then
            call console%message('warning: no figures are drawn: '//book%reason)
        else
            call fail(error, integer_text(book%not_drawn)//' figures could not be drawn; the page says '// &
                      'so in their places. '//book%reason)
        end if
    end subroutine show

    !> 10^{-9} as 1e-9 has no place in a terminal: the braces go.
    pure function without_marks(text) result(plain)
        character(*), intent(in) :: text
        character(:), allocatable :: plain

        integer :: i

        plain = ''
        do i = 1, len(text)
            if (scan(text(i:i), '{}') == 0) plain = plain//text(i:i)
        end do
    end function without_marks
end module gracecg_cli_report
