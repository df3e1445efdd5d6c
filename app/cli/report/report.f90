!> gracecg report: everything that CSR-TM-00-01 shows, computed anew. Each study leaves its numbers in a folder as CSV files;
!> the Python package sets them beside the published ones, judges them and makes one HTML page.
module gracecg_cli_report
    use gracecg_base_constants, only: NANOTESLA
    use gracecg_simulation_report_cases, only: REPORT_CASE_NAMES, SATELLITES, TIME_OF_CASE
    use gracecg_planning_calibration, only: find_calibration, calibration_text, write_calibration
    use gracecg_studies_campaign, only: campaign_t, agreement_of, report_campaign, first_runs
    use gracecg_studies_campaign_files, only: write_table, write_runs
    use gracecg_studies_published, only: com_budget_table, published_axes_table, ALLOWED_BAND
    use gracecg_studies_curves, only: verification_t, verify_case, curves_table, curves_file_name, check_windows, &
        begin_windows, add_window_rows, WINDOW_TOLERANCE, CENTRE_TOLERANCE
    use gracecg_studies_designed_manoeuvre, only: design_study_t, study_design, designed_calibration_t, &
        calibrate_with_design, design_map_table, designed_calibrations_table, DESIGN_ALGORITHM, LOWEST_FREQUENCY
    use gracecg_studies_error_sources, only: error_study_t, study_all_errors, error_table, STUDY_NAMES
    use gracecg_studies_estimate_windows, only: campaign_windows, loss_windows, estimate_windows_table, &
        LEAST_SHARE_INSIDE
    use gracecg_studies_gravity_gradient, only: gradient_along_orbit, gradient_table
    use gracecg_studies_limit, only: limit_study_t, study_limit, limits_table, detectable_excess
    use gracecg_studies_magnetometer_loss, only: field_study_t, study_magnetometer_loss, field_table, &
        field_runs_table, field_settings, MODEL_FIELD_ERROR
    use gracecg_studies_statements, only: statement_t, examine_statement, statement_table, STATEMENT_NAMES
    use gracecg_studies_timing, only: timing_study_t, study_timing, places_table, marked_places_table, &
        revolutions_table
    use gracecg_cli_campaign_tables, only: REPORT_RUNS, put_agreement
    use gracecg_cli_statements, only: put_statements
    use gracecg_spacecraft_torque_rods, only: WAVEFORM_NAMES
    use gracecg_cli_cases, only: case_place, amplitudes_of
    use gracecg_cli_work
    use, intrinsic :: iso_fortran_env, only: compiler_version
    use gracecg_base_statistics, only: sampling_error
    use gracecg_base_version, only: file_comments
    use gracecg_files_file, only: make_directory, remove_file
    use gracecg_cli_page_program, only: make_page, RESULT_FILE
    implicit none
    private
    public :: declare_report, run_report, report_folder_t, open_report, COMMAND, PAGE_NAME

    integer, parameter :: ORBIT_STEP = 10           !! Between the places of a revolution, s
    real(dp), parameter :: GRADIENT_OFFSET(3) = MILLIMETRE/sqrt(3.0_dp) !! "about 1 mm", the axes alike, m
    integer, parameter :: GRADIENT_STEP = 10        !! Samples of the orbit
    character(*), parameter :: SOURCES_CASE = 'front-1', SOURCES_ALGORITHM = 'ascfest'     !! As in the report
    character(*), parameter :: BY_THEORY = 'arc-length'     !! The statement whose runs would take the longest

    character(*), parameter :: COMMAND = 'report'           !! Name of the command
    character(*), parameter :: PAGE_NAME = 'index.html'     !! Name of the page in the folder

    !> The folder as it fills, and how its numbers are computed.
    type :: report_folder_t
        integer :: runs = 0                         !! Of every Monte Carlo
        integer :: threads = 1                      !! To work on
        integer(i8) :: seed = 1                     !! Of the random numbers
        type(results_t) :: results                  !! result.json in the making
        character(:), allocatable, private :: path
        type(string_t), allocatable, private :: names(:)    !! Of the CSV files
    contains
        procedure :: file                   !! The path of a new file, which is noted
        procedure :: put                    !! Writes a table
        procedure :: finish                 !! Writes result.json and makes the page
    end type report_folder_t

contains

    !> Says what the command takes.
    subroutine declare_report(arguments)
        type(arguments_t), intent(inout) :: arguments

        call arguments%describe(COMMAND, '', 0, 0, &
                                'Runs everything that CSR-TM-00-01 shows - Tables 1.1, 1.2, 6.1 and 6.2, Figures 3.1, '// &
                                '5.2 to 5.8 and 6.1 to 6.6 - and writes one HTML page, '//PAGE_NAME//', with each beside '// &
                                'the published numbers, a CSV file for every table and figure, and the figures as SVG; '// &
                                'what it states without them; then, beyond the report, every estimator against the '// &
                                'theoretical limit, and a designed manoeuvre. The page takes Python.', &
                                'gracecg report --out report --runs 30')
        call arguments%add_option('--out', 'DIR', 'folder for '//PAGE_NAME//' and the other files; made if it is not there', &
                                  required=.true.)
        call arguments%add_option('--runs', 'N', 'of every Monte Carlo, at least '//integer_text(REPORT_RUNS)//', which the '// &
                                  'report has', default='200')
        call add_study_options(arguments, '--seed --threads')
    end subroutine declare_report

    !> Computes the studies and makes the page.
    subroutine run_report(arguments, console, misuse, error)
        type(arguments_t), intent(in) :: arguments
        type(console_t), intent(inout) :: console
        type(error_t), allocatable, intent(out) :: misuse, error

        type(report_folder_t) :: folder
        type(study_t) :: study

        call take_options(arguments, console, study, misuse, REPORT_RUNS)
        if (allocated(misuse)) return
        call open_report(study%path, study%runs, study%seed, study%threads, folder, error)
        if (allocated(error)) return
        console%logs_progress = .true.
        call console%expect_parts(2*size(SATELLITES) + 2*size(REPORT_CASE_NAMES) + 3 + size(STATEMENT_NAMES), 'parts')
        call put_inputs(folder, error)
        if (.not. allocated(error)) call put_revolutions(folder, console, error)
        if (.not. allocated(error)) call put_estimates(folder, console, error)
        if (.not. allocated(error)) call put_error_sources(folder, console, error)
        if (.not. allocated(error)) call examine_all(folder, console, error)
        if (.not. allocated(error)) call put_limits(folder, console, error)
        if (.not. allocated(error)) call put_designs(folder, console, error)
        if (.not. allocated(error)) call folder%finish(console, error)
    end subroutine run_report

    !> What the report is given: the cases, the budget of the centre of mass, the ends of the printed axes.
    subroutine put_inputs(folder, error)
        type(report_folder_t), intent(inout) :: folder
        type(error_t), allocatable, intent(out) :: error

        type(calibration_t) :: calibrations(size(REPORT_CASE_NAMES))
        type(data_table_t) :: table
        character(:), allocatable :: text
        integer :: i

        call folder%results%begin('case_files')
        do i = 1, size(calibrations)
            call find_calibration(REPORT_CASE_NAMES(i), calibrations(i), error)
            if (.not. allocated(error)) call calibration_text(calibrations(i), text, error)
            if (allocated(error)) return
            call folder%results%member(trim(REPORT_CASE_NAMES(i)), text)
        end do
        call folder%results%end()
        call report_cases_table(calibrations, table, error)
        if (.not. allocated(error)) call folder%put('cases', table, 'the six cases', error)
        if (.not. allocated(error)) call folder%put('com_budget', com_budget_table(), 'Tables 1.1 and 1.2', error)
        if (.not. allocated(error)) call folder%put('printed_axes', published_axes_table(), 'Figures 6.1 to 6.6', error)
    end subroutine put_inputs

    !> A revolution of either satellite, its case 1 against the printed windows, the gradient along the front one's.
    subroutine put_revolutions(folder, console, error)
        type(report_folder_t), intent(inout) :: folder
        type(console_t), intent(inout) :: console
        type(error_t), allocatable, intent(out) :: error

        type(timing_study_t) :: revolutions(size(SATELLITES))
        type(data_table_t) :: windows
        integer :: i

        call begin_windows(windows, .true.)
        do i = 1, size(SATELLITES)
            call put_revolution(folder, trim(SATELLITES(i)), revolutions(i), windows, console, error)
            if (allocated(error)) return
            call console%next_part()
        end do
        call folder%results%member('window_tolerance', WINDOW_TOLERANCE)
        call folder%results%member('centre_tolerance', CENTRE_TOLERANCE)
        call folder%put('revolutions', revolutions_table(revolutions), 'section 6.2', error)
        if (.not. allocated(error)) call folder%put('windows', windows, 'case 1 and the axes of Figures 5.2 to 5.8', error)
        if (.not. allocated(error)) call folder%put('gravity_gradient', gradient_table(gradient_along_orbit( &
            revolutions(1)%orbit, GRADIENT_OFFSET, GRADIENT_STEP)), &
            'front satellite; offset 1 mm, its components alike; radial, transverse, normal', error)
    end subroutine put_revolutions

    subroutine put_revolution(folder, satellite, revolution, windows, console, error)
        type(report_folder_t), intent(inout) :: folder
        character(*), intent(in) :: satellite
        type(timing_study_t), intent(out) :: revolution
        type(data_table_t), intent(inout) :: windows    !! Gets rows
        type(console_t), intent(inout) :: console
        type(error_t), allocatable, intent(out) :: error

        type(calibration_t) :: calibration
        type(verification_t) :: curves
        character(:), allocatable :: name

        call find_calibration(satellite//'-1', calibration, error)
        if (.not. allocated(error)) call study_timing(calibration, ORBIT_STEP, folder%threads, revolution, error, console)
        if (.not. allocated(error)) call verify_case(revolution%case, curves, error)
        if (allocated(error)) return
        call add_window_rows(calibration%case%name, check_windows(satellite, curves), windows)
        name = curves_file_name(calibration%case%name)
        call folder%put(name(:index(name, '.csv') - 1), curves_table(curves), 'case '//satellite//'-1; body axes', error)
        if (.not. allocated(error)) call folder%put('timing_'//satellite, places_table(revolution%places, &
            revolution%case%epoch), satellite//' satellite; field in body axes', error)
        if (.not. allocated(error)) call folder%put('places_'//satellite, marked_places_table(revolution), &
                                                    satellite//' satellite; field in body axes', error)
    end subroutine put_revolution

    !> The six cases by the report's algorithms, and the loss of the magnetometer, against the printed axes.
    subroutine put_estimates(folder, console, error)
        type(report_folder_t), intent(inout) :: folder
        type(console_t), intent(inout) :: console
        type(error_t), allocatable, intent(out) :: error

        type(campaign_t) :: campaign
        type(field_study_t), allocatable :: losses(:)
        character(100) :: about

        call report_campaign(folder%seed, folder%runs, folder%threads, campaign, error, console)
        call console%next_part()
        if (.not. allocated(error)) call write_table(folder%file('montecarlo.csv'), campaign, COMMAND, error)
        if (.not. allocated(error)) call write_table(folder%file('montecarlo_first_runs.csv'), &
                                                     first_runs(campaign, REPORT_RUNS), COMMAND, error)
        if (.not. allocated(error)) call write_runs(folder%file('montecarlo_runs.csv'), campaign, COMMAND, error)
        if (.not. allocated(error)) call study_magnetometer_loss('front', MODEL_FIELD_ERROR, folder%seed, folder%runs, &
                                                                 folder%threads, losses, error, console)
        call console%next_part()
        if (allocated(error)) return
        call put_agreement(agreement_of(campaign), folder%results)
        call folder%results%member('allowed_band', ALLOWED_BAND)
        call folder%results%member('least_share_inside', LEAST_SHARE_INSIDE)
        call folder%results%member('field_error_nt', MODEL_FIELD_ERROR/NANOTESLA)
        about = field_settings(folder%seed, MODEL_FIELD_ERROR)
        call folder%put('estimate_windows', estimate_windows_table([campaign_windows(campaign, 1), &
            campaign_windows(campaign, 2), loss_windows(losses)]), 'axes of Figures 6.2, 6.3 and 6.6', error)
        if (.not. allocated(error)) call folder%put('magnetometer_loss', field_table(losses), trim(about), error)
        if (.not. allocated(error)) call folder%put('magnetometer_loss_runs', field_runs_table(losses), trim(about), error)
    end subroutine put_estimates

    !> Figure 6.5.
    subroutine put_error_sources(folder, console, error)
        type(report_folder_t), intent(inout) :: folder
        type(console_t), intent(inout) :: console
        type(error_t), allocatable, intent(out) :: error

        type(calibration_t) :: calibration
        type(error_study_t) :: sources(size(STUDY_NAMES))

        call find_calibration(SOURCES_CASE, calibration, error)
        if (.not. allocated(error)) call study_all_errors(calibration, SOURCES_ALGORITHM, folder%seed, folder%runs, &
                                                          folder%threads, sources, error, console)
        call console%next_part()
        if (.not. allocated(error)) call folder%put('errors', error_table(sources), SOURCES_CASE//', '// &
            SOURCES_ALGORITHM//', seed '//integer_text(folder%seed), error)
    end subroutine put_error_sources

    !> What the report states without a table or a figure.
    subroutine examine_all(folder, console, error)
        type(report_folder_t), intent(inout) :: folder
        type(console_t), intent(inout) :: console
        type(error_t), allocatable, intent(out) :: error

        type(statement_t) :: statements(size(STATEMENT_NAMES))
        integer :: i

        do i = 1, size(statements)
            call examine_statement(STATEMENT_NAMES(i), merge(0, folder%runs, STATEMENT_NAMES(i) == BY_THEORY), folder%seed, &
                                   folder%threads, statements(i), error, console)
            if (allocated(error)) return
            call console%next_part()
        end do
        call put_statements(statements, folder%results)
        call folder%put('statements', statement_table(statements), 'seed '//integer_text(folder%seed)// &
                        '; 0 runs: theory alone', error)
    end subroutine examine_all

    !> Beyond the report: every estimator against the limit.
    subroutine put_limits(folder, console, error)
        type(report_folder_t), intent(inout) :: folder
        type(console_t), intent(inout) :: console
        type(error_t), allocatable, intent(out) :: error

        type(limit_study_t) :: limits(size(REPORT_CASE_NAMES))
        type(calibration_t) :: calibration
        integer :: i

        do i = 1, size(limits)
            call find_calibration(REPORT_CASE_NAMES(i), calibration, error)
            if (.not. allocated(error)) call study_limit(calibration, folder%seed, folder%runs, folder%threads, limits(i), &
                                                         error, console)
            if (allocated(error)) return
            call console%next_part()
        end do
        call folder%results%member('detectable_excess', detectable_excess(folder%runs))
        call folder%put('bound', limits_table(limits), 'seed '//integer_text(folder%seed)// &
                        '; systematic errors off; sampling_error: one sigma of the ratio', error)
    end subroutine put_limits

    !> Beyond the report: a designed manoeuvre for either satellite, and what it reaches in the cases.
    subroutine put_designs(folder, console, error)
        type(report_folder_t), intent(inout) :: folder
        type(console_t), intent(inout) :: console
        type(error_t), allocatable, intent(out) :: error

        type(design_study_t) :: designs(size(SATELLITES))
        type(designed_calibration_t) :: reached(size(REPORT_CASE_NAMES))
        integer :: i

        do i = 1, size(designs)
            call study_design(trim(SATELLITES(i)), folder%threads, designs(i), error, console)
            if (.not. allocated(error)) call folder%put('manoeuvre_map_'//trim(SATELLITES(i)), design_map_table(designs(i)), &
                'theoretical limit, the worst direction last, of the manoeuvre of case 1 and of the designed one', error)
            if (.not. allocated(error)) call write_calibration(folder%file('designed_'//trim(SATELLITES(i))//'.nml'), &
                                                        designs(i)%calibration, error)
            if (allocated(error)) return
            call console%next_part()
        end do
        do i = 1, size(reached)
            call calibrate_with_design(REPORT_CASE_NAMES(i), &
                                       designs(merge(1, 2, index(REPORT_CASE_NAMES(i), 'front') == 1))%design, &
                                       folder%seed, folder%runs, folder%threads, reached(i), error, console)
            if (allocated(error)) return
            call console%next_part()
        end do
        call folder%results%member('design_places', designs(1)%places)
        call folder%results%member('design_lowest_frequency_hz', LOWEST_FREQUENCY)
        call folder%put('designed_manoeuvres', manoeuvres_table(designs), 'three rods, for either satellite', error)
        if (.not. allocated(error)) call folder%put('design', designed_calibrations_table(reached), DESIGN_ALGORITHM// &
            ', all errors on, seed '//integer_text(folder%seed), error)
    end subroutine put_designs

    !> Where, when and with which settings of the models each case is. Fails when a case's models cannot be built.
    subroutine report_cases_table(calibrations, table, error)
        type(calibration_t), intent(in) :: calibrations(:)
        type(data_table_t), intent(out) :: table
        type(error_t), allocatable, intent(out) :: error

        real(dp) :: latitude, longitude, height
        integer :: i

        call table%columns_of('case,epoch_utc,orbit_time_s,latitude_deg,longitude_deg,height_km,rod_x_a_m2,rod_y_a_m2,'// &
                              'rod_z_a_m2,offset_x_mm,offset_y_mm,offset_z_mm,gravity_model,gravity_degree,gravity_order,'// &
                              'density_model,density_scale,drag_coefficient,wind_model,wind_east_m_s,wind_north_m_s,'// &
                              'wave_random,wave_amplitude,wave_period_s,reflectivity_sun,specular,diffuse,earth_segments,'// &
                              'earth_constants,reflectivity_earth,field_model,strongest_rod_a_m2,accommodation,centre_x_mm,'// &
                              'centre_y_mm,centre_z_mm')
        do i = 1, size(calibrations)
            call case_place(calibrations(i)%case, latitude, longitude, height, error)
            if (allocated(error)) return
            associate (case => calibrations(i)%case, body => calibrations(i)%case%satellite, &
                       rings => calibrations(i)%case%earth_radiation_rings)
                call table%add(case%name, utc_text(case%epoch))
                call table%add([TIME_OF_CASE(case%number), latitude/DEGREE, longitude/DEGREE, height/1000, &
                                amplitudes_of(body%rods), body%offset/MILLIMETRE])
                call table%add(case%gravity_model, real([case%gravity_degree, case%gravity_order], dp))
                call table%add(case%density_model, [case%density_scale, body%drag_coefficient])
                call table%add(case%wind_model, [case%wind_east, case%wind_north])
                call table%add(case%density_wave_random)
                call table%add([case%density_wave%amplitude, case%density_wave%period, body%reflectivity_sun, body%specular, &
                                body%diffuse, 1.0_dp + 3*rings*(rings + 1)])
                call table%add(case%earth_radiation_constants, [body%reflectivity_earth])
                call table%add(case%field_model, [maxval(abs(body%rods%activations%amplitude)), body%wall%accommodation, &
                                                  body%centre_of_mass/MILLIMETRE])
            end associate
        end do
    end subroutine report_cases_table

    !> The designed manoeuvres, a row each activation of a rod.
    function manoeuvres_table(studies) result(table)
        type(design_study_t), intent(in) :: studies(:)
        type(data_table_t) :: table

        integer :: i, k

        call table%columns_of('satellite,rod,waveform,amplitude_a_m2,frequency_hz,phase_deg,start_s,stop_s')
        do i = 1, size(studies)
            do k = 1, studies(i)%design%rods%count
                associate (rod => studies(i)%design%rods%activations(k))
                    call table%add(studies(i)%calibration%case%satellite%name, AXES(rod%axis), WAVEFORM_NAMES(rod%waveform))
                    call table%add([rod%amplitude, rod%frequency, rod%phase/DEGREE, rod%start, rod%stop])
                end associate
            end do
        end do
    end function manoeuvres_table

    !> Begins the folder, which is made where there is none. A page and a result.json of before go at once: they would tell
    !> of files that are no longer theirs. Fails when nothing can be written there.
    subroutine open_report(path, runs, seed, threads, folder, error)
        character(*), intent(in) :: path            !! Of the folder
        integer, intent(in) :: runs, threads        !! Of every Monte Carlo; in parallel
        integer(i8), intent(in) :: seed             !! Of the random numbers
        type(report_folder_t), intent(out) :: folder
        type(error_t), allocatable, intent(out) :: error

        call make_directory(path, error)
        if (.not. allocated(error)) call check_writable(path//'/'//PAGE_NAME, error)
        if (allocated(error)) return
        call remove_file(path//'/'//PAGE_NAME)
        call remove_file(path//'/'//RESULT_FILE)
        folder%path = path
        folder%runs = runs
        folder%seed = seed
        folder%threads = threads
        allocate (folder%names(0))
        call folder%results%open(COMMAND)
        call folder%results%member('compiler', compiler_version())
        call folder%results%member('runs', runs)
        call folder%results%member('report_runs', REPORT_RUNS)
        call folder%results%member('seed', seed)
        call folder%results%member('sampling_error', sampling_error(runs))
    end subroutine open_report

    !> The path of a new file, which is noted.
    function file(self, name) result(path)
        class(report_folder_t), intent(inout) :: self
        character(*), intent(in) :: name    !! Of the file, with its ending
        character(:), allocatable :: path

        call append(self%names, name)
        path = self%path//'/'//name
    end function file

    !> Writes a table as NAME.csv. Fails when a number is not finite, or the file cannot be written.
    subroutine put(self, name, table, about, error)
        class(report_folder_t), intent(inout) :: self
        character(*), intent(in) :: name            !! Of the table
        type(data_table_t), intent(in) :: table
        character(*), intent(in) :: about           !! Its settings, for NAME.csv.meta.json
        type(error_t), allocatable, intent(out) :: error

        call table%write(self%file(name//'.csv'), file_comments(COMMAND, about), error)
    end subroutine put

    !> Writes result.json and makes the page; shows what the page's maker says.
    subroutine finish(self, console, error)
        class(report_folder_t), intent(inout) :: self
        type(console_t), intent(inout) :: console
        type(error_t), allocatable, intent(out) :: error

        character(:), allocatable :: json, said

        call self%results%member('files', self%names)
        call self%results%end()
        call self%results%finish(json, error)
        if (.not. allocated(error)) call make_page(self%path//'/'//PAGE_NAME, json, error, self%path, said)
        if (allocated(error)) return
        call console%line(said)
        call console%line('written to '//self%path)
    end subroutine finish
end module gracecg_cli_report
