!> gracecg report: everything that CSR-TM-00-01 shows, as one HTML page.
!>
!> The studies compute; each chapter is a module of cli/report: it writes the CSV files of a study,
!> adds text, tables and figures to the book, and notes what was found for the summary.
module gracecg_cli_report
    use, intrinsic :: iso_fortran_env, only: compiler_version
    use gracecg_base_kinds, only: dp, i8
    use gracecg_base_constants, only: MILLIMETRE
    use gracecg_base_error, only: error_t
    use gracecg_base_version, only: VERSION
    use gracecg_base_text, only: integer_text
    use gracecg_files_json, only: json_quoted
    use gracecg_cli_results, only: results_t
    use gracecg_files_file, only: make_directory, check_writable
    use gracecg_simulation_report_cases, only: REPORT_CASE_NAMES
    use gracecg_planning_calibration, only: calibration_t, find_calibration
    use gracecg_studies_campaign, only: campaign_t, report_campaign
    use gracecg_studies_curves, only: verification_t, verify_case
    use gracecg_studies_designed_manoeuvre, only: design_study_t, study_design, designed_calibration_t, &
        calibrate_with_design
    use gracecg_studies_error_sources, only: error_study_t, study_all_errors, STUDY_NAMES
    use gracecg_studies_gravity_gradient, only: gradient_along_orbit
    use gracecg_studies_limit, only: limit_study_t, study_limit
    use gracecg_studies_magnetometer_loss, only: field_study_t, study_magnetometer_loss, LOSS_STUDIES, &
        MODEL_FIELD_ERROR
    use gracecg_studies_statements, only: statement_t, examine_statement, STATEMENT_NAMES
    use gracecg_studies_window_sensitivity, only: variation_t, study_window_sensitivity, VARIATIONS
    use gracecg_studies_timing, only: timing_study_t, study_timing
    use gracecg_cli_arguments, only: arguments_t, MOST_RUNS
    use gracecg_cli_console, only: console_t
    use gracecg_cli_campaign_tables, only: REPORT_RUNS
    use gracecg_cli_document, only: document_t, table_rows_t, head_cell, text_cell, verdict_cell, VERDICT_MET, &
        VERDICT_PARTLY, VERDICT_MISSED, VERDICT_KINDS
    use gracecg_cli_page_program, only: make_page
    use gracecg_cli_number_text, only: share_text
    use gracecg_cli_report_book, only: report_book_t, open_book, COMMAND, SATELLITES
    use gracecg_cli_chapter_simulation, only: add_simulation_chapter
    use gracecg_cli_chapter_budget, only: add_budget_chapter
    use gracecg_cli_chapter_gradient, only: add_gradient_chapter
    use gracecg_cli_chapter_curves, only: add_curves_chapter
    use gracecg_cli_chapter_timing, only: add_field_chapter, add_timing_chapter
    use gracecg_cli_chapter_accuracy, only: add_accuracy_chapter
    use gracecg_cli_chapter_sources, only: add_sources_chapter, SOURCES_CASE, SOURCES_ALGORITHM
    use gracecg_cli_chapter_loss, only: add_loss_chapter
    use gracecg_cli_chapter_statements, only: add_statements_chapter, page_runs
    use gracecg_cli_chapter_limit, only: add_limit_chapter
    use gracecg_cli_chapter_design, only: add_design_chapter
    implicit none
    private
    public :: declare_report, run_report

    character(*), parameter :: PAGE_NAME = 'index.html'
    integer, parameter :: DEFAULT_RUNS = 200
    integer, parameter :: ORBIT_STEP = 10           !! Between the places of a revolution, s
    real(dp), parameter :: GRADIENT_OFFSET(3) = MILLIMETRE/sqrt(3.0_dp) !! "about 1 mm", the axes alike, m
    integer, parameter :: GRADIENT_STEP = 10        !! Samples of the orbit

contains

    !> Says what the command takes.
    subroutine declare_report(arguments)
        type(arguments_t), intent(inout) :: arguments

        call arguments%describe(COMMAND, '', 0, 0, &
                                'Runs everything that CSR-TM-00-01 shows - Tables 1.1, 1.2, 6.1 and '// &
                                '6.2, Figures 3.1, 5.2 to 5.8 and 6.1 to 6.6 - and writes one HTML '// &
                                'page, '//PAGE_NAME//', with each beside the published numbers, a CSV '// &
                                'file for every figure, and the figures as SVG; what it states without them; '// &
                                'then, beyond the report, every estimator against the theoretical limit, and a '// &
                                'designed manoeuvre. The page takes Python.', &
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
        type(document_t) :: page
        character(:), allocatable :: folder
        integer(i8) :: seed        !! Of the random numbers
        integer :: runs, threads

        call arguments%get('--out', folder, misuse)
        call arguments%get('--runs', runs, misuse, default=DEFAULT_RUNS, low=REPORT_RUNS, high=MOST_RUNS)
        call arguments%get('--seed', seed, misuse, default=1_i8)
        call arguments%get_threads(threads, misuse)
        if (allocated(misuse)) return
        call make_directory(folder, error)
        if (.not. allocated(error)) call check_writable(folder//'/'//PAGE_NAME, error)
        if (allocated(error)) return

        call open_book(book, folder)
        book%runs = runs
        book%seed = seed
        call add_chapters(book, threads, console, error)
        if (allocated(error)) return
        call add_summary(page, book)
        call page%append(book%page)
        call add_making(page, book)
        call write_page(book, page, error)
        call show(book, console)
    end subroutine run_report

    !> The page, of result.json beside it: title, lead, what was found, and the blocks of the page.
    subroutine write_page(book, page, error)
        type(report_book_t), intent(in) :: book
        type(document_t), intent(in) :: page
        type(error_t), allocatable, intent(out) :: error

        type(results_t) :: results
        character(:), allocatable :: text
        integer :: i

        call results%open(COMMAND)
        call results%member('title', 'GRACE CG offset determination by magnetic torquers: CSR-TM-00-01 recomputed')
        call results%member('lead', 'The centre-of-gravity calibration of the GRACE satellites, as F. Wang''s '// &
                            'report CSR-TM-00-01 (The University of Texas at Austin, January 2000) '// &
                            'simulates it, computed anew by gracecg '//VERSION// &
                            ': every table and figure of results beside the published numbers, or beside '// &
                            'the printed axes where the curves are lost.')
        call results%member('runs', book%runs)
        call results%member('seed', book%seed)
        call results%begin_array('claims')
        do i = 1, size(book%claims)
            associate (claim => book%claims(i))
                call results%begin()
                call results%member('source', trim(claim%source))
                call results%member('claim', trim(claim%claim))
                call results%member('result', trim(claim%result))
                call results%member('kind', trim(VERDICT_KINDS(claim%kind)))
                call results%member('verdict', trim(claim%verdict))
                call results%end()
            end associate
        end do
        call results%end()
        call results%raw('blocks', page%blocks())
        call results%end()
        call results%finish(text, error)
        if (.not. allocated(error)) call make_page(book%folder//'/'//PAGE_NAME, text, error, book%folder)
    end subroutine write_page

    !> Computes the studies and adds their chapters, in the order of the report.
    subroutine add_chapters(book, threads, console, error)
        type(report_book_t), intent(inout) :: book
        integer, intent(in) :: threads
        type(console_t), intent(inout) :: console
        type(error_t), allocatable, intent(out) :: error

        type(timing_study_t) :: revolutions(2)
        type(verification_t) :: curves(2)
        type(variation_t) :: changes(VARIATIONS)
        type(campaign_t) :: campaign
        type(error_study_t) :: sources(size(STUDY_NAMES))
        type(field_study_t) :: losses(LOSS_STUDIES)
        type(statement_t) :: statements(size(STATEMENT_NAMES))
        type(calibration_t) :: calibration
        integer :: i

        call console%expect_parts(2*size(SATELLITES) + 2*size(REPORT_CASE_NAMES) + 3 + size(STATEMENT_NAMES), 'parts')
        call add_simulation_chapter(book, error)
        if (allocated(error)) return
        call add_budget_chapter(book)
        do i = 1, size(SATELLITES)
            call find_calibration(trim(SATELLITES(i))//'-1', calibration, error)
            if (.not. allocated(error)) call study_timing(calibration, ORBIT_STEP, threads, revolutions(i), error, console)
            if (.not. allocated(error)) call verify_case(revolutions(i)%case, curves(i), error)
            if (allocated(error)) return
            call console%next_part()
        end do
        call add_gradient_chapter(book, gradient_along_orbit(revolutions(1)%orbit, GRADIENT_OFFSET, GRADIENT_STEP), &
                                  error)
        if (.not. allocated(error)) call study_window_sensitivity(threads, changes, error)
        if (.not. allocated(error)) call add_curves_chapter(book, curves, changes, error)
        if (.not. allocated(error)) call add_field_chapter(book, revolutions, error)
        if (.not. allocated(error)) call report_campaign(book%seed, book%runs, threads, campaign, error, console)
        call console%next_part()
        if (.not. allocated(error)) call add_accuracy_chapter(book, campaign, error)
        if (.not. allocated(error)) call add_timing_chapter(book, revolutions, error)
        if (.not. allocated(error)) call find_calibration(SOURCES_CASE, calibration, error)
        if (.not. allocated(error)) call study_all_errors(calibration, SOURCES_ALGORITHM, book%seed, book%runs, threads, &
                                                          sources, error, console)
        call console%next_part()
        if (.not. allocated(error)) call add_sources_chapter(book, sources, error)
        if (.not. allocated(error)) call study_magnetometer_loss('front', MODEL_FIELD_ERROR, book%seed, book%runs, &
                                                                 threads, losses, error, console)
        call console%next_part()
        if (.not. allocated(error)) call add_loss_chapter(book, losses, error)
        do i = 1, size(STATEMENT_NAMES)
            if (allocated(error)) return
            call examine_statement(STATEMENT_NAMES(i), page_runs(STATEMENT_NAMES(i), book%runs), book%seed, threads, &
                                   statements(i), error, console)
            call console%next_part()
        end do
        if (.not. allocated(error)) call add_statements_chapter(book, statements, error)
        if (.not. allocated(error)) call add_chapters_beyond(book, threads, console, error)
    end subroutine add_chapters

    !> What the report does not have: every estimator against the limit, and a designed manoeuvre.
    subroutine add_chapters_beyond(book, threads, console, error)
        type(report_book_t), intent(inout) :: book
        integer, intent(in) :: threads
        type(console_t), intent(inout) :: console
        type(error_t), allocatable, intent(out) :: error

        type(limit_study_t) :: limits(size(REPORT_CASE_NAMES))
        type(design_study_t) :: designs(size(SATELLITES))
        type(designed_calibration_t) :: reached(size(REPORT_CASE_NAMES))
        type(calibration_t) :: calibration
        integer :: i

        do i = 1, size(REPORT_CASE_NAMES)
            call find_calibration(REPORT_CASE_NAMES(i), calibration, error)
            if (.not. allocated(error)) call study_limit(calibration, book%seed, book%runs, threads, limits(i), error, console)
            if (allocated(error)) return
            call console%next_part()
        end do
        call add_limit_chapter(book, limits, error)
        do i = 1, size(SATELLITES)
            if (allocated(error)) return
            call study_design(trim(SATELLITES(i)), threads, designs(i), error, console)
            call console%next_part()
        end do
        do i = 1, size(REPORT_CASE_NAMES)
            if (allocated(error)) return
            call calibrate_with_design(REPORT_CASE_NAMES(i), &
                                       designs(merge(1, 2, index(REPORT_CASE_NAMES(i), 'front') == 1))%design, &
                                       book%seed, book%runs, threads, reached(i), error, console)
            call console%next_part()
        end do
        if (.not. allocated(error)) call add_design_chapter(book, designs, reached, error)
    end subroutine add_chapters_beyond

    !> What was found, a line for each figure and table.
    subroutine add_summary(page, book)
        type(document_t), intent(inout) :: page
        type(report_book_t), intent(in) :: book

        type(table_rows_t) :: rows
        integer :: i

        associate (kinds => book%claims%kind)
            call page%chapter('summary', 'Summary')
            call page%paragraph('Each line leads to its table or figure. Verdicts: '// &
                                share_text(count(kinds == VERDICT_MET), size(kinds))//' agree without a remark, '// &
                                integer_text(count(kinds == VERDICT_PARTLY))//' with one, '// &
                                integer_text(count(kinds == VERDICT_MISSED))//' differ.')
        end associate
        do i = 1, size(book%claims)
            associate (claim => book%claims(i))
                call rows%add(head_cell(trim(claim%source), anchor=trim(claim%anchor))// &
                              verdict_cell(claim%kind, trim(claim%verdict))// &
                              text_cell(trim(claim%claim), wraps=.true.)//text_cell(trim(claim%result), wraps=.true.))
            end associate
        end do
        call page%table('What the report shows, and what is found here', [character(16) :: 'report', 'verdict', &
                        'the report shows', 'found here'], rows, 'findings', stacks=.true.)
    end subroutine add_summary

    !> Settings, versions, files.
    subroutine add_making(page, book)
        type(document_t), intent(inout) :: page
        type(report_book_t), intent(in) :: book

        type(table_rows_t) :: rows
        character(:), allocatable :: names
        integer :: i

        call page%chapter('making', 'How this page was made')
        call add_setting('command', 'gracecg report --runs '//integer_text(book%runs)//' --seed '// &
                         integer_text(book%seed))
        call add_setting('runs of every Monte Carlo', integer_text(book%runs))
        call add_setting('seed of the random numbers', integer_text(book%seed))
        call add_setting('gracecg', VERSION)
        call add_setting('compiler', compiler_version())
        call page%table('Settings and versions', [character(8) :: 'setting', 'value'], rows, 'settings')
        call page%paragraph('The same command gives the same numbers on every machine and with any '// &
                            'number of threads. The numbers of the figures stand beside this page as '// &
                            'CSV, the figures as SVG; all that the page says is in `result.json`.')
        names = ''
        do i = 1, size(book%files)
            names = names//json_quoted(book%files(i)%text)//','
        end do
        call page%files(names)

    contains

        subroutine add_setting(name, value)
            character(*), intent(in) :: name, value

            call rows%add(head_cell(name)//text_cell(value, wraps=.true.))
        end subroutine add_setting
    end subroutine add_making

    !> What was found and written.
    subroutine show(book, console)
        type(report_book_t), intent(in) :: book
        type(console_t), intent(inout) :: console

        integer :: i

        do i = 1, size(book%claims)
            associate (claim => book%claims(i))
                call console%line(claim%source//trim(claim%verdict)//': '//trim(without_marks(trim(claim%result))))
            end associate
        end do
        call console%line('')
        call console%line('written to '//book%folder//': '//PAGE_NAME//', '//integer_text(size(book%files))// &
                          ' data files, '//integer_text(book%figures)//' figures')
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
