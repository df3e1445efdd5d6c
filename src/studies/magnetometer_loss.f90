!> The loss of the magnetometer, CSR-TM-00-01 section 6.4: in place of its samples the field of the
!> spherical harmonic model, which is wrong by a constant of each run.
!>
!> The true field of a simulation is that of the model, so the model's error is added to the truth:
!> constant over the arc in body axes, normal, drawn for every run.
module gracecg_studies_magnetometer_loss
    use gracecg_base_kinds, only: dp, i8
    use gracecg_base_constants, only: MILLIMETRE, NANOTESLA, AXES
    use gracecg_base_error, only: error_t
    use gracecg_base_progress, only: progress_t, tell, expect_pieces
    use gracecg_base_text, only: integer_text, real_text
    use gracecg_files_data_table, only: data_table_t
    use gracecg_base_random, only: random_stream_t, new_stream
    use gracecg_environment_thermosphere, only: density_wave_t
    use gracecg_observations_observation_set, only: observation_set_t
    use gracecg_estimation_options, only: estimation_options_t
    use gracecg_estimation_solution, only: solution_t
    use gracecg_estimation_estimators, only: estimate_offset
    use gracecg_simulation_simulator, only: simulator_t, new_simulator, observe_without_noise
    use gracecg_planning_calibration, only: calibration_t, find_calibration
    use gracecg_studies_monte_carlo, only: alteration_t, prediction_t, predict_errors, monte_carlo_t, run_monte_carlo, &
        rms_of_errors
    implicit none
    private
    public :: field_model_t, predict_field_model, field_study_t, study_field, MODEL_FIELD_ERROR, FIELD_SOURCES
    public :: study_magnetometer_loss, study_loss_of_cases, LOSS_ALGORITHMS
    public :: field_table, field_runs_table, field_settings

    real(dp), parameter :: MODEL_FIELD_ERROR = 150e-9_dp    !! Standard deviation of an axis, T, section 6.4
    integer, parameter :: STREAM_FIELD_MODEL = 6            !! Of the random numbers of one run
    character(8), parameter :: FIELD_SOURCES(2) = [character(8) :: 'measured', 'model']
    !! Where the field comes from: without and with the field model

    integer, parameter :: LOSS_CASES(2) = [2, 3]            !! Of Figure 6.6
    character(7), parameter :: LOSS_ALGORITHMS(2) = [character(7) :: 'ascfest', 'ascrest']  !! Likewise

    !> Many calibrations of one case with one source of the field.
    type :: field_study_t
        character(64) :: case_name = ''    !! Of the case that was run
        character(16) :: algorithm = ''    !! One of ESTIMATOR_NAMES
        logical :: with_model = .false.             !! Else the magnetometer measures the field
        integer, allocatable :: run(:)              !! Numbers of the runs
        real(dp), allocatable :: offset(:, :)       !! Estimates, (3, runs), m
        real(dp) :: rms(3) = 0                      !! Of their errors, m
        real(dp) :: predicted(3) = 0                !! By theory, m
    end type field_study_t

    !> Puts the field model in the place of the magnetometer.
    type, extends(alteration_t) :: field_model_t
        real(dp) :: deviation = MODEL_FIELD_ERROR           !! Of the model's error, T
    contains
        procedure :: alter => take_model_field
    end type field_model_t

contains

    !> Figure 6.6: cases 2 and 3 of a satellite, as study_loss_of_cases.
    subroutine study_magnetometer_loss(satellite, deviation, seed, runs, threads, studies, error, progress)
        character(*), intent(in) :: satellite       !! 'front' or 'back'
        real(dp), intent(in) :: deviation           !! Of the model's error, T
        integer(i8), intent(in) :: seed             !! Of the random numbers
        integer, intent(in) :: runs, threads        !! Runs of each Monte Carlo; in parallel
        type(field_study_t), allocatable, intent(out) :: studies(:)     !! By case, algorithm, source of the field
        type(error_t), allocatable, intent(out) :: error
        class(progress_t), intent(inout), optional :: progress      !! Counts the runs

        type(calibration_t) :: calibrations(size(LOSS_CASES))
        integer :: i

        do i = 1, size(LOSS_CASES)
            call find_calibration(satellite//'-'//integer_text(LOSS_CASES(i)), calibrations(i), error)
            if (allocated(error)) return
        end do
        call study_loss_of_cases(calibrations, deviation, seed, runs, threads, studies, error, progress)
    end subroutine study_magnetometer_loss

    !> Cases with each of LOSS_ALGORITHMS, with measured and with modelled field in turns.
    subroutine study_loss_of_cases(calibrations, deviation, seed, runs, threads, studies, error, progress)
        type(calibration_t), intent(in) :: calibrations(:)
        real(dp), intent(in) :: deviation           !! Of the model's error, T
        integer(i8), intent(in) :: seed        !! Of the random numbers
        integer, intent(in) :: runs, threads  !! Runs of each Monte Carlo; in parallel
        type(field_study_t), allocatable, intent(out) :: studies(:)     !! By case, algorithm, source of the field
        type(error_t), allocatable, intent(out) :: error
        class(progress_t), intent(inout), optional :: progress

        type(simulator_t) :: simulator
        integer :: i, a, f, n

        allocate (studies(size(calibrations)*size(LOSS_ALGORITHMS)*size(FIELD_SOURCES)))
        call expect_pieces(progress, size(studies)*runs, 'runs')
        n = 0
        do i = 1, size(calibrations)
            call new_simulator(calibrations(i)%case, simulator, error)
            if (allocated(error)) return
            do a = 1, size(LOSS_ALGORITHMS)
                do f = 1, size(FIELD_SOURCES)
                    call tell(progress, trim(calibrations(i)%case%name)//', '//LOSS_ALGORITHMS(a)//', '// &
                              trim(FIELD_SOURCES(f))//' field')
                    n = n + 1
                    call study_field(simulator, LOSS_ALGORITHMS(a), calibrations(i)%options, FIELD_SOURCES(f) == 'model', &
                                     deviation, seed, runs, threads, studies(n), error, progress)
                    if (allocated(error)) return
                end do
            end do
        end do
    end subroutine study_loss_of_cases

    !> Simulates and estimates `runs` calibrations with the magnetometer or with the field model in its
    !> place, and predicts their errors. Fails as `run_monte_carlo` does.
    subroutine study_field(simulator, algorithm, options, with_model, deviation, seed, runs, threads, study, error, &
                           progress)
        type(simulator_t), intent(in) :: simulator
        character(*), intent(in) :: algorithm    !! One of ESTIMATOR_NAMES
        type(estimation_options_t), intent(in) :: options
        logical, intent(in) :: with_model    !! The field model instead of the magnetometer
        real(dp), intent(in) :: deviation           !! Of the model's error, T
        integer(i8), intent(in) :: seed        !! Of the random numbers
        integer, intent(in) :: runs, threads    !! Runs of the Monte Carlo; in parallel
        type(field_study_t), intent(out) :: study
        type(error_t), allocatable, intent(out) :: error
        class(progress_t), intent(inout), optional :: progress      !! Counts the runs

        type(monte_carlo_t) :: results
        type(prediction_t) :: prediction
        integer :: i

        study%case_name = simulator%case%name
        study%algorithm = algorithm
        study%with_model = with_model
        study%run = [(i, i=1, runs)]
        if (with_model) then
            call predict_field_model(simulator, algorithm, options, deviation, study%predicted, error)
            if (allocated(error)) return
            call run_monte_carlo(simulator, algorithm, options, seed, study%run, threads, results, error, &
                                 field_model_t(deviation), progress)
        else
            call predict_errors(simulator, algorithm, options, prediction, error)
            if (allocated(error)) return
            study%predicted = prediction%rms
            call run_monte_carlo(simulator, algorithm, options, seed, study%run, threads, results, error, &
                                 progress=progress)
        end if
        if (allocated(error)) return
        study%offset = results%offset
        study%rms = rms_of_errors(results, simulator)
    end subroutine study_field

    subroutine take_model_field(self, simulator, seed, run, observations)
        class(field_model_t), intent(in) :: self
        type(simulator_t), intent(in) :: simulator
        integer(i8), intent(in) :: seed        !! Of the random numbers
        integer, intent(in) :: run
        type(observation_set_t), intent(inout) :: observations

        type(random_stream_t) :: stream
        real(dp) :: draws(3)

        associate (case => simulator%case)
            stream = new_stream(seed, case%label(), case%satellite%place(), run, STREAM_FIELD_MODEL)
        end associate
        call stream%normals(draws)
        call set_field(simulator, self%deviation*draws, observations)
    end subroutine take_model_field

    !> The model's field at the magnetometer's epochs, wrong by a constant.
    pure subroutine set_field(simulator, field_error, observations)
        type(simulator_t), intent(in) :: simulator
        real(dp), intent(in) :: field_error(3)      !! Body axes, T
        type(observation_set_t), intent(inout) :: observations

        integer :: i, k

        do i = 1, size(observations%magnetometer_time)
            k = nint(observations%magnetometer_time(i)/simulator%arc%interval)
            observations%field(:, i) = simulator%arc%loads(k)%field + field_error
        end do
    end subroutine set_field

    !> Predicted RMS error of the offset with the field model, m: that of accelerometer, star camera
    !> and dynamics, and the estimate's response to the model's error, which is linear, axis by axis.
    subroutine predict_field_model(simulator, algorithm, options, deviation, rms, error)
        type(simulator_t), intent(in) :: simulator
        character(*), intent(in) :: algorithm       !! One of ESTIMATOR_NAMES
        type(estimation_options_t), intent(in) :: options
        real(dp), intent(in) :: deviation           !! Of the model's error, T
        real(dp), intent(out) :: rms(3)             !! Body axes, m
        type(error_t), allocatable, intent(out) :: error

        type(simulator_t) :: without_bias
        type(prediction_t) :: prediction
        type(observation_set_t) :: exact, observations
        type(estimation_options_t) :: own
        type(solution_t) :: solution
        real(dp) :: still(3), field_error(3)
        integer :: axis

        rms = 0
        without_bias = simulator
        without_bias%case%satellite%magnetometer%bias = 0
        call predict_errors(without_bias, algorithm, options, prediction, error)
        if (allocated(error)) return
        rms = prediction%rms**2
        still = simulator%case%satellite%offset + prediction%bias
        own = options
        own%covariance = .false.
        call observe_without_noise(simulator, density_wave_t(), exact)
        do axis = 1, 3
            field_error = 0
            field_error(axis) = deviation
            observations = exact
            call set_field(simulator, field_error, observations)
            call estimate_offset(algorithm, observations, own, solution, error)
            if (allocated(error)) return
            rms = rms + (solution%offset - still)**2
        end do
        rms = sqrt(rms)
    end subroutine predict_field_model

    !> Figure 6.6: RMS errors with measured and with modelled field, beside what theory expects.
    function field_table(studies) result(table)
        type(field_study_t), intent(in) :: studies(:)
        type(data_table_t) :: table

        integer :: i, axis

        call table%column('case', 'a', 'case')
        call table%column('algorithm', 'a', 'algorithm')
        call table%column('magnetometer', 'a', 'field')
        call table%column('axis', 'a', 'axis')
        call table%column('runs')
        call table%column('rms_mm', 'f10.5', 'here')
        call table%column('predicted_mm', 'f10.5', 'theory')
        do i = 1, size(studies)
            do axis = 1, 3
                call add_labels(studies(i), table)
                call table%add(AXES(axis))
                call table%add([real(size(studies(i)%run), dp), [studies(i)%rms(axis), studies(i)%predicted(axis)]/MILLIMETRE])
            end do
        end do
    end function field_table

    !> The estimates of every run with measured and with modelled field.
    function field_runs_table(studies) result(table)
        type(field_study_t), intent(in) :: studies(:)
        type(data_table_t) :: table

        integer :: i, k

        call table%columns_of('case,algorithm,magnetometer,run,dx_mm,dy_mm,dz_mm')
        do i = 1, size(studies)
            do k = 1, size(studies(i)%run)
                call add_labels(studies(i), table)
                call table%add(studies(i)%run(k))
                call table%add(studies(i)%offset(:, k)/MILLIMETRE)
            end do
        end do
    end function field_runs_table

    !> Case, algorithm and source of the field.
    subroutine add_labels(study, table)
        type(field_study_t), intent(in) :: study
        type(data_table_t), intent(inout) :: table

        call table%add(study%case_name, study%algorithm, FIELD_SOURCES(merge(2, 1, study%with_model)))
    end subroutine add_labels

    !> What the studies were made with, in words.
    function field_settings(seed, deviation) result(text)
        integer(i8), intent(in) :: seed             !! Of the runs
        real(dp), intent(in) :: deviation           !! Of the model's error, T
        character(100) :: text    !! With blanks behind it

        text = 'seed '//integer_text(seed)//', error of the field model '// &
               real_text(anint(deviation/NANOTESLA*1e6_dp)/1e6_dp)//' nT'
    end function field_settings
end module gracecg_studies_magnetometer_loss
