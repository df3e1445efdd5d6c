!> gracecg magnetometer-loss: Figure 6.6 of CSR-TM-00-01, the field model in place of the magnetometer.
module gracecg_cli_magnetometer_loss
    use gracecg_base_kinds, only: dp, i8
    use gracecg_base_constants, only: MILLIMETRE, NANOTESLA
    use gracecg_base_error, only: error_t
    use gracecg_environment_magnetic_storm, only: storm_field_deviation
    use gracecg_files_file, only: check_writable
    use gracecg_base_text, only: integer_text, real_text, rounded_text
    use gracecg_base_version, only: file_comments
    use gracecg_files_data_table, only: data_table_t
    use gracecg_studies_magnetometer_loss, only: field_study_t, study_loss_of_cases, field_table, field_settings, &
        names_of_loss_cases, MODEL_FIELD_ERROR, FIELD_SOURCES
    use gracecg_planning_calibration, only: calibration_t
    use gracecg_cli_calibration_argument, only: add_options_option, add_cases_option, take_calibrations, &
        warn_of_instruments, MOST_CASES
    use gracecg_cli_arguments, only: arguments_t, refuse_if, MOST_RUNS
    use gracecg_cli_campaign_tables, only: wide
    use gracecg_cli_console, only: console_t
    use gracecg_cli_results, only: results_t, add_format_option, take_format
    implicit none
    private
    public :: declare_magnetometer_loss, run_magnetometer_loss

    character(5), parameter :: SATELLITES(2) = ['front', 'back ']
    real(dp), parameter :: REPORT_FIELD_ERROR = anint(MODEL_FIELD_ERROR/NANOTESLA)  !! nT
    real(dp), parameter :: MOST_FIELD_ERROR = 1e5_dp    !! nT

    !> What the user asks for.
    type :: request_t
        character(:), allocatable :: satellite, path
        integer(i8) :: seed = 1        !! Of the random numbers
        integer :: runs = 0, threads = 1
        real(dp) :: deviation_nt = 0                !! Of the model's error, nT
        real(dp) :: kp = -1                         !! That it comes from; negative: from none
    end type request_t

contains

    !> Arguments and help of `gracecg magnetometer-loss`.
    subroutine declare_magnetometer_loss(arguments)
        type(arguments_t), intent(inout) :: arguments

        call arguments%describe('magnetometer-loss', '[CASE ...]', 0, MOST_CASES, &
                                'The RMS error of the CG offset when the magnetometer has failed and the '// &
                                'field of the spherical harmonic model takes its place, as in Figure 6.6 of '// &
                                'CSR-TM-00-01: ASCFEST and ASCREST, for the cases named or, as in the report, '// &
                                'for front-2 and front-3. The model is wrong by a '// &
                                'constant vector in body axes, drawn for every run.', &
                                'gracecg magnetometer-loss front-2 back-2 --runs 20')
        call add_cases_option(arguments, 'cases 2 and 3 of --satellite')
        call arguments%add_option('--runs', 'N', 'of each case (default 100)')
        call arguments%add_option('--satellite', 'NAME', 'front (default) or back: its cases 2 and 3, where no CASE is named', &
                                  choices=SATELLITES)
        call arguments%add_option('--field-error', 'NT', 'standard deviation of the model''s error on each '// &
                                  'axis, nT (default 150, as in the report)')
        call arguments%add_option('--kp', 'KP', 'in its place: that of a geomagnetic index Kp, 0 to 9, by (6.1) of '// &
                                  'the report, 42 nT at 2.5')
        call arguments%add_option('--seed', 'S', 'of the random numbers (default 1)')
        call arguments%add_option('--threads', 'N', 'to work on (default: the processors of the machine)')
        call arguments%add_option('--out', 'FILE', 'CSV file for the RMS errors')
        call add_format_option(arguments)
        call add_options_option(arguments)
    end subroutine declare_magnetometer_loss

    !> The work of `gracecg magnetometer-loss`.
    subroutine run_magnetometer_loss(arguments, console, misuse, error)
        type(arguments_t), intent(in) :: arguments
        type(console_t), intent(inout) :: console
        type(error_t), allocatable, intent(out) :: misuse, error

        type(request_t) :: request
        type(field_study_t), allocatable :: studies(:)
        type(calibration_t), allocatable :: calibrations(:)
        type(results_t) :: results
        type(data_table_t) :: table
        integer :: i

        call read_request(arguments, request, misuse)
        call take_format(arguments, console, misuse)
        if (allocated(misuse)) return
        call check_writable(request%path, error)
        if (.not. allocated(error)) &
            call take_calibrations(arguments, names_of_loss_cases(request%satellite), console, calibrations, misuse, error)
        if (allocated(misuse) .or. allocated(error)) return
        do i = 1, size(calibrations)
            call warn_of_instruments(calibrations(i)%case, console)
        end do
        call study_loss_of_cases(calibrations, request%deviation_nt*NANOTESLA, request%seed, request%runs, &
                                     request%threads, studies, error, console)
        if (allocated(error)) return
        call show(request, studies, console)
        call results%open('magnetometer-loss')
        call results%member('seed', request%seed)
        call results%member('field_error_nt', request%deviation_nt)
        call results%publish(field_table(studies), console, error)
        if (allocated(error)) return
        table = field_table(studies)
        if (request%path /= '') call table%write(request%path, file_comments('magnetometer-loss', field_settings( &
            request%seed, request%deviation_nt*NANOTESLA)), error)
    end subroutine run_magnetometer_loss

    subroutine read_request(arguments, request, misuse)
        type(arguments_t), intent(in) :: arguments
        type(request_t), intent(out) :: request
        type(error_t), allocatable, intent(out) :: misuse

        call arguments%get('--runs', request%runs, misuse, default=100, low=1, high=MOST_RUNS)
        call arguments%get('--satellite', request%satellite, misuse, default='front', choices=SATELLITES)
        call refuse_if(arguments%has('--satellite') .and. (arguments%positional_count() > 0 .or. arguments%has('--cases')), &
                       'option --satellite and a CASE exclude each other: a case names its satellite', misuse)
        call arguments%get('--field-error', request%deviation_nt, misuse, default=REPORT_FIELD_ERROR, &
                           low=0.0_dp, high=MOST_FIELD_ERROR, unit='nT')
        call refuse_if(arguments%has('--kp') .and. arguments%has('--field-error'), &
                       '--kp and --field-error both say how wrong the field model is: give one', misuse)
        if (arguments%has('--kp')) then
            call arguments%get('--kp', request%kp, misuse, low=0.0_dp, high=9.0_dp)
            request%deviation_nt = storm_field_deviation(request%kp)/NANOTESLA
        end if
        call arguments%get('--seed', request%seed, misuse, default=1_i8)
        call arguments%get_threads(request%threads, misuse)
        call arguments%get('--out', request%path, misuse, default='')
    end subroutine read_request

    subroutine show(request, studies, console)
        type(request_t), intent(in) :: request
        type(field_study_t), intent(in) :: studies(:)
        type(console_t), intent(inout) :: console

        character(100) :: row
        character(:), allocatable :: index_text
        integer :: i, axis, width

        index_text = ''
        if (request%kp >= 0) index_text = ', by (6.1) at Kp = '//real_text(request%kp)
        call console%paragraph('RMS error of the CG offset, mm: '//integer_text(request%runs)// &
                               ' runs; error of the field model '//rounded_text(request%deviation_nt, 6)// &
                               ' nT on each axis'//index_text)
        width = max(9, maxval(len_trim(studies%case_name)) + 2)
        call console%line(wide('case', width)//'algorithm  field       x here  x theory    y here  y theory    z here'// &
                          '  z theory')
        do i = 1, size(studies)
            associate (s => studies(i))
                write (row, '(a, t12, a, t20, 6f10.5)') trim(s%algorithm), &
                    FIELD_SOURCES(merge(2, 1, s%with_model)), &
                    (s%rms(axis)/MILLIMETRE, s%predicted(axis)/MILLIMETRE, axis=1, 3)
            end associate
            call console%line(wide(trim(studies(i)%case_name), width)//trim(row))
        end do
    end subroutine show
end module gracecg_cli_magnetometer_loss
